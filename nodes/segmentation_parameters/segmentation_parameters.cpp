#include "nodes/segmentation_parameters/segmentation_parameters.h"

#include <string>

#include "nodes/platform_source/platform_source.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node.h"
#include "prehend/grasp/closing/widest_opening.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"
#include "prehend/shape/body_evidence.h"

namespace prehend::nodes {
namespace {

/// A node that declares parameters, and whether they count at the start only.
struct Declarer {
  graph::Node& node;
  bool at_start;
};

void declare_length(const Declarer& declarer, const std::string& name, double value,
                    const std::string& description, double minimum = 0, double maximum = 100) {
  declarer.node.declare_parameter<double>({.name = name,
                                           .default_value = value,
                                           .unit = "m",
                                           .minimum = minimum,
                                           .maximum = maximum,
                                           .description = description,
                                           .read_only = declarer.at_start});
}

void declare_count(const Declarer& declarer, const std::string& name, int value, int minimum,
                   int maximum, const std::string& unit, const std::string& description) {
  declarer.node.declare_parameter<int>({.name = name,
                                        .default_value = value,
                                        .unit = unit,
                                        .minimum = minimum,
                                        .maximum = maximum,
                                        .description = description,
                                        .read_only = declarer.at_start});
}

void declare_table_parameters(const Declarer& declarer) {
  const perception::TableOptions table;
  declare_length(declarer, "table.inlier_distance", table.inlier_distance,
                 "distance to the table within which a point belongs to it, at 1 m", 1e-4, 0.1);
  declare_count(declarer, "table.max_iterations", table.max_iterations, 1, 100000, "",
                "RANSAC draws for each plane");
  declare_count(declarer, "table.max_planes", table.max_planes, 1, 20, "",
                "planes that are looked at");
  declarer.node.declare_parameter<double>(
      {.name = "table.min_support",
       .default_value = table.min_support,
       .minimum = 0.0,
       .maximum = 1.0,
       .description = "share of all points that a table must have",
       .read_only = declarer.at_start});
  declare_length(declarer, "table.min_extent", table.min_extent, "shorter side of a table");
  declarer.node.declare_parameter<double>({.name = "table.max_tilt",
                                           .default_value = table.max_tilt,
                                           .unit = "rad",
                                           .minimum = 0.01,
                                           .maximum = 1.5708,
                                           .description =
                                               "largest angle between table normal and up, where "
                                               "up is known",
                                           .read_only = declarer.at_start});
  declare_length(declarer, "table.leaf_size", table.leaf_size, "voxels the table is sought in", 0,
                 0.1);
  declare_length(declarer, "table.max_distance", table.max_distance,
                 "farther points are not looked at for the table", 0.1);
  declare_count(declarer, "seed", static_cast<int>(table.seed), 0, 1000000, "",
                "of the random draws; same seed, same result");
}

}  // namespace

SegmentationParameters::SegmentationParameters(graph::Node& node, bool at_start) : node_(node) {
  const Declarer declarer{node, at_start};
  declare_table_parameters(declarer);
  const perception::SegmentationOptions o;
  declare_length(declarer, "min_height", o.min_height,
                 "lower points belong to the table, up to 1 m depth; 0: by the table's noise", 0,
                 0.1);
  declare_length(declarer, "max_height", o.max_height, "points higher over the table are dropped");
  declare_length(declarer, "max_distance", o.max_distance,
                 "points farther from the camera are dropped", 0.1);
  declare_length(declarer, "cluster_tolerance", o.cluster_tolerance,
                 "gap that separates two objects", 1e-3, 0.5);
  declare_length(declarer, "leaf_size", o.leaf_size, "voxels that are clustered", 0, 0.1);
  node.declare_parameter<double>({.name = "min_area",
                                  .default_value = o.min_area,
                                  .unit = "m^2",
                                  .minimum = 0,
                                  .maximum = 1,
                                  .description = "that is seen of the smallest object",
                                  .read_only = at_start});
  declare_length(declarer, "min_object_height", o.min_object_height, "lower things are dropped");
  declare_length(declarer, "hull_margin", o.hull_margin, "by which the table's outline is widened");
  declare_count(declarer, "close_radius", o.close_radius, 0, 50, "px",
                "of the closing that fills small holes of the masks");
  declare_count(declarer, "max_objects", o.max_objects, 1, 200, "", "the largest are kept");
  node.declare_parameter<std::string>(
      {.name = "clustering",
       .default_value = "euclidean",
       .choices = {"euclidean", "organized"},
       .description = "how points become objects; organized is faster, for clouds that are images",
       .read_only = at_start});
  node.declare_parameter<std::string>(
      {.name = "split",
       .default_value = "tops",
       .choices = {"none", "tops", "touching", "shapes", "wide"},
       .description = "what takes things apart that touch: level tops at different heights; in "
                      "clouds that are images also touching: creases between colours; shapes: "
                      "creases where two completed shapes explain more than one; wide: as shapes, "
                      "of what is wider across the table than the platform's hand opens",
       .read_only = at_start});
  const auto platform = node.declare_parameter<std::string>(
      {.name = "platform",
       .description = "the robot that grasps what is found (stage_pg70, kr5_sdh, ...), or its "
                      "file, for split=wide; empty: unknown",
       .read_only = true});
  const std::string platforms = declare_platforms(node);
  if (!platform.empty()) {
    const auto file = robot::platform_file(platforms, platform);
    widest_opening_ = grasp::widest_opening(robot::read_platform(file).hand);
  }
  declare_length(declarer, "join_gap", o.parts.join_gap,
                 "within which a floating part belongs to a larger object");
  segmentation();  // a platform that is missing is said at the start
}

perception::TableOptions SegmentationParameters::table() const {
  perception::TableOptions o;
  o.inlier_distance = node_.parameter<double>("table.inlier_distance");
  o.max_iterations = node_.parameter<int>("table.max_iterations");
  o.max_planes = node_.parameter<int>("table.max_planes");
  o.min_support = node_.parameter<double>("table.min_support");
  o.min_extent = node_.parameter<double>("table.min_extent");
  o.max_tilt = node_.parameter<double>("table.max_tilt");
  o.leaf_size = node_.parameter<double>("table.leaf_size");
  o.max_distance = node_.parameter<double>("table.max_distance");
  o.seed = static_cast<std::uint64_t>(node_.parameter<int>("seed"));
  return o;
}

perception::SegmentationOptions SegmentationParameters::segmentation() const {
  perception::SegmentationOptions o;
  o.min_height = node_.parameter<double>("min_height");
  o.max_height = node_.parameter<double>("max_height");
  o.max_distance = node_.parameter<double>("max_distance");
  o.cluster_tolerance = node_.parameter<double>("cluster_tolerance");
  o.leaf_size = node_.parameter<double>("leaf_size");
  o.min_area = node_.parameter<double>("min_area");
  o.min_object_height = node_.parameter<double>("min_object_height");
  o.hull_margin = node_.parameter<double>("hull_margin");
  o.close_radius = node_.parameter<int>("close_radius");
  o.max_objects = node_.parameter<int>("max_objects");
  o.parts.join_gap = node_.parameter<double>("join_gap");
  if (node_.parameter<std::string>("clustering") == "organized") {
    o.clustering = perception::Clustering::kOrganized;
  }
  perception::choose_splitting(node_.parameter<std::string>("split"), widest_opening_, &o);
  o.body_evidence = shape::log_odds_of_one_body;
  return o;
}

}  // namespace prehend::nodes
