#include <chrono>
#include <string>
#include <vector>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "msgs/objects.pb.h"
#include "nodes/segmentation_parameters/segmentation_parameters.h"
#include "nodes/segmentation_parameters/stage_clock.h"
#include "nodes/stage_fidelity/stage_fidelity.h"
#include "prehend/geometry/cloud_files.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/perception/recorded_cloud.h"

namespace {

using namespace prehend;

perception::RecordedCloudOptions read_options(graph::Node& node) {
  const auto scale = node.declare_parameter<double>({.name = "scale",
                                                     .default_value = 1.0,
                                                     .minimum = 1e-9,
                                                     .maximum = 1e9,
                                                     .description = "metres per unit of the file",
                                                     .read_only = true});
  const auto viewpoint = node.declare_parameter<std::string>(
      {.name = "viewpoint",
       .description = "pose of the camera's optical frame in the file's frame: x y z qw qx qy qz; "
                      "empty: found out from the file",
       .read_only = true});
  const auto up = node.declare_parameter<std::string>(
      {.name = "up",
       .description = "direction up in the file's frame: x y z; empty: unknown",
       .read_only = true});
  const auto table = node.declare_parameter<std::string>(
      {.name = "table",
       .default_value = "auto",
       .description = "auto: a small cloud without a table is one object; find: there is a table; "
                      "none: the cloud is one object; a b c d: it is the plane a x + b y + c z = d "
                      "of the file's frame [m], normal towards the objects",
       .read_only = true});
  return perception::read_recorded_cloud_options(scale, viewpoint, up, table);
}

// What the node was asked for.
struct Asked {
  const nodes::SegmentationParameters& parameters;
  const nodes::StageFidelity& stage;
  int points;

  // By the parameters, or by the front.
  fidelity::SeeingOptions seeing() const {
    fidelity::SeeingOptions options;
    options.points = points;
    options.segmentation = parameters.segmentation();
    options.table = parameters.table();
    if (const auto& chosen = stage.chosen()) {
      fidelity::apply_segmentation_setting(chosen->setting, &options);
    }
    return options;
  }
};

// A cloud without table or objects is an answer: it is published and the node stays.
msgs::ObjectHypotheses segment(const Asked& asked, const perception::RecordedCloud& recorded,
                               perception::RecordedWorld world, msgs::ObjectHypotheses times,
                               nodes::StageClock& clock) {
  msgs::ObjectHypotheses message;
  try {
    const fidelity::SeeingOptions seeing = asked.seeing();
    const perception::SegmentedScene scene = perception::segment_recorded_cloud(
        thinned(recorded, seeing.points), seeing.segmentation, seeing.table, world);
    message = convert::to_message(scene);
    if (scene.objects.empty()) {
      message.set_problem(perception::why_no_objects(scene));
    }
  } catch (const geometry::InputError& error) {
    message.set_problem(error.what());
  }
  clock.end_stage(times, "segmentation");
  message.mutable_times()->Swap(times.mutable_times());
  return message;
}

void run(graph::Node& node) {
  const auto file = node.declare_parameter<std::string>({.name = "file",
                                                         .description = "a .pcd or .ply cloud",
                                                         .read_only = true,
                                                         .reads_file = true});
  const perception::RecordedCloudOptions options = read_options(node);
  const auto world = node.declare_parameter<std::string>(
      {.name = "world",
       .default_value = "table",
       .choices = {"table", "file"},
       .description = "frame of the objects: made from the table that is found, or the file's own, "
                      "as several clouds of one scene need (view_merging)",
       .read_only = true});
  const nodes::SegmentationParameters parameters(node, true);
  const int points = node.declare_parameter<int>(
      {.name = "points",
       .default_value = 0,
       .minimum = 0,
       .description = "of a cloud that is an image: about so many are looked at, of each square of "
                      "its pixels that of the median depth; 0: all",
       .read_only = true});
  const nodes::StageFidelity fidelity(node, fidelity::Stage::kSegmentation,
                                      {"clustering", "points", "table.leaf_size"});
  const auto publisher = node.advertise<msgs::ObjectHypotheses>("/objects", graph::QoS::latched());
  const auto seen = node.advertise<msgs::PointCloud>("/camera/cloud", graph::QoS::latched());
  const auto publish = [&node, &publisher](msgs::ObjectHypotheses message) {
    message.mutable_header()->set_frame_id("world");
    message.mutable_header()->set_stamp(node.clock().now());
    publisher.publish(std::move(message));
  };

  nodes::StageClock clock;
  msgs::ObjectHypotheses times;
  msgs::ObjectHypotheses message;
  try {
    if (file.empty()) {
      throw geometry::InputError("Parameter file is empty", "Name a .pcd or .ply cloud");
    }
    const geometry::CloudFile cloud = geometry::read_cloud_file(file);
    clock.end_stage(times, "read");
    const perception::RecordedCloud recorded = perception::interpret_recorded_cloud(cloud, options);
    clock.end_stage(times, "viewpoint");
    if (needs_organized(parameters.segmentation().split) && !recorded.cloud_C.organized()) {
      throw geometry::InputError("Parameter split=" + node.parameter<std::string>("split") +
                                     " needs a cloud that is an image, '" + file + "' is none",
                                 "Leave it away (split:= of the launch files)");
    }
    for (const std::string& note : recorded.notes) node.log_info("{}: {}", file, note);
    // Its colours are what the camera saw; a cloud that is no image has none to look at.
    const geometry::PointCloud& cloud_C = recorded.cloud_C;
    if (cloud_C.organized() && !cloud_C.colors.empty()) seen.publish(convert::to_message(cloud_C));
    message = segment(
        {parameters, fidelity, points}, recorded,
        world == "file" ? perception::RecordedWorld::kFile : perception::RecordedWorld::kTable,
        std::move(times), clock);
    for (const std::string& note : recorded.notes) message.add_notes(note);
  } catch (const geometry::InputError& error) {
    message.set_problem(error.what());
    publish(message);  // for those who listen already; the launch shows the reason too
    throw;
  }
  if (message.problem().empty()) {
    node.report(graph::Health::kOk, fmt::format("{} objects in {}", message.objects_size(), file));
  } else {
    node.report(graph::Health::kWarning, fmt::format("{}: {}", file, message.problem()));
  }
  publish(std::move(message));
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"cloud_source",
     "Reads a recorded point cloud, works out from where it was seen, finds the table and the "
     "objects on it, and publishes them once on /objects (latched); a cloud that is an image with "
     "colours also on /camera/cloud, in the camera's optical frame. A file that cannot be used "
     "ends "
     "the node with the reason."},
    run);

}  // namespace
