#include <exception>
#include <optional>
#include <string>
#include <vector>

#include "msgs/convert/geometry.h"
#include "msgs/convert/objects.h"
#include "msgs/objects.pb.h"
#include "nodes/stage_fidelity/stage_fidelity.h"
#include "prehend/fidelity/shape_settings.h"
#include "prehend/graph/node_program.h"
#include "prehend/surface/model.h"

namespace {

using namespace prehend;

constexpr std::size_t kMostObjects = 32;  // that wait for a late reader
const std::string kFastPoisson = "fast_poisson";
const std::string kPclPoisson = "pcl_poisson";

void declare_parameters(graph::Node& node) {
  const surface::ModelOptions o;
  node.declare_parameter<std::string>({.name = "method",
                                       .default_value = kFastPoisson,
                                       .choices = {kFastPoisson, kPclPoisson},
                                       .description = "of the surface"});
  const surface::FastPoissonOptions& fast = o.surface.fast_poisson;
  node.declare_parameter<int>({.name = "resolution",
                               .default_value = fast.resolution,
                               .minimum = 32,
                               .maximum = 256,
                               .description =
                                   "fast_poisson: nodes along the grid's longest side, a "
                                   "multiple of 16",
                               .validate = [](const int& nodes) {
                                 return std::string(nodes % 16 == 0 ? "" : "not a multiple of 16");
                               }});
  node.declare_parameter<double>({.name = "finest_detail",
                                  .default_value = surface::kFinestDetail,
                                  .unit = "m",
                                  .minimum = 0.0,
                                  .maximum = 0.1,
                                  .description = "nodes of fast_poisson are no nearer to each "
                                                 "other, points no nearer either: half a diagonal "
                                                 "of a pad's texel; 0: as near as resolution and "
                                                 "spacing say"});
  node.declare_parameter<double>({.name = "screening_weight",
                                  .default_value = fast.point_weight,
                                  .minimum = 0.0,
                                  .maximum = 1000.0,
                                  .description = "fast_poisson: of the points besides their "
                                                 "normals; small for noisy points"});
  const surface::PclPoissonOptions& pcl = o.surface.pcl_poisson;
  node.declare_parameter<int>({.name = "depth",
                               .default_value = pcl.depth,
                               .minimum = 3,
                               .maximum = 10,
                               .description = "pcl_poisson: of the octree; detail doubles and time "
                                              "grows about fourfold with each"});
  node.declare_parameter<double>({.name = "samples_per_node",
                                  .default_value = pcl.samples_per_node,
                                  .minimum = 1.0,
                                  .maximum = 20.0,
                                  .description = "pcl_poisson: more for noisier clouds"});
  node.declare_parameter<double>(
      {.name = "point_weight",
       .default_value = pcl.point_weight,
       .minimum = 0.0,
       .maximum = 100.0,
       .description = "pcl_poisson: of the points besides their normals"});
  node.declare_parameter<double>({.name = "scale",
                                  .default_value = pcl.scale,
                                  .minimum = 1.1,
                                  .maximum = 3.0,
                                  .description = "reconstruction cube over the cloud's extent"});
  node.declare_parameter<bool>({.name = "close_bottom",
                                .default_value = o.surface.close_bottom,
                                .description = "close the object on the table"});
  node.declare_parameter<bool>({.name = "close_sides",
                                .default_value = o.close_sides,
                                .description = "close sides between seen and mirrored points"});
  node.declare_parameter<double>({.name = "spacing",
                                  .default_value = o.cloud.spacing,
                                  .unit = "m",
                                  .minimum = 0.0,
                                  .maximum = 0.1,
                                  .description = "voxel in which points are averaged; 0: 1/90 of "
                                                 "the extent"});
  node.declare_parameter<int>({.name = "normal_neighbors",
                               .default_value = o.cloud.normals.neighbors,
                               .minimum = 3,
                               .maximum = 200,
                               .description = "points that a normal is fitted to"});
  node.declare_parameter<double>({.name = "outlier_deviations",
                                  .default_value = o.cloud.outliers.deviations,
                                  .minimum = 0.1,
                                  .maximum = 100.0,
                                  .description = "standard deviations beyond which points go"});
  node.declare_parameter<double>({.name = "concavity",
                                  .default_value = o.convex_pieces.concavity,
                                  .unit = "m",
                                  .minimum = 0.0001,
                                  .maximum = 1.0,
                                  .description = "how far a convex piece may reach beyond the "
                                                 "solid"});
}

surface::ModelOptions model_options(const graph::Node& node,
                                    const std::optional<nodes::ChosenStage>& chosen) {
  surface::ModelOptions o(node.parameter<double>("finest_detail"));
  const std::string method = node.parameter<std::string>("method");
  o.surface.method = method == kPclPoisson ? surface::SurfaceMethod::kPclPoisson
                                           : surface::SurfaceMethod::kFastPoisson;
  o.surface.fast_poisson.resolution = node.parameter<int>("resolution");
  o.surface.fast_poisson.point_weight = node.parameter<double>("screening_weight");
  o.surface.fast_poisson.scale = node.parameter<double>("scale");
  o.surface.pcl_poisson.depth = node.parameter<int>("depth");
  o.surface.pcl_poisson.samples_per_node = node.parameter<double>("samples_per_node");
  o.surface.pcl_poisson.point_weight = node.parameter<double>("point_weight");
  o.surface.pcl_poisson.scale = node.parameter<double>("scale");
  o.surface.close_bottom = node.parameter<bool>("close_bottom");
  o.close_sides = node.parameter<bool>("close_sides");
  o.cloud.spacing = node.parameter<double>("spacing");
  o.cloud.normals.neighbors = node.parameter<int>("normal_neighbors");
  o.cloud.outliers.deviations = node.parameter<double>("outlier_deviations");
  o.convex_pieces.concavity = node.parameter<double>("concavity");
  if (chosen) {
    const surface::ModelOptions front = fidelity::shape_options(chosen->setting).model;
    o.cloud.spacing = front.cloud.spacing;
    o.surface.method = front.surface.method;
    o.surface.fast_poisson.resolution = front.surface.fast_poisson.resolution;
    o.surface.pcl_poisson.depth = front.surface.pcl_poisson.depth;
  }
  return o;
}

void add_time(msgs::ObjectModel& message, const char* stage, double seconds) {
  msgs::StageTime* time = message.add_times();
  time->set_stage(stage);
  time->set_seconds(seconds);
}

class PoissonMeshing {
 public:
  explicit PoissonMeshing(graph::Node& node) : node_(node) {
    declare_parameters(node);
    fidelity_.emplace(node, fidelity::Stage::kShape,
                      std::vector<std::string>{"method", "resolution", "depth", "spacing"});
    publisher_ = node.advertise<msgs::ObjectModel>("/models", graph::QoS::latched(kMostObjects));
    subscription_ = node.subscribe<msgs::CompletedShape>(
        "/shapes", graph::QoS::queue(kMostObjects),
        [this](const graph::Received<msgs::CompletedShape>& message) { publish(*message); });
  }

 private:
  /// The model of one shape, or why there is none.
  msgs::ObjectModel to_model(const msgs::CompletedShape& shape) const {
    msgs::ObjectModel message;
    if (!shape.completed()) {
      message.set_problem("not completed: " + shape.problem());
      return message;
    }
    const std::string problem = node_.shield(fmt::format("object {}", shape.id()), [&] {
      const std::optional<nodes::ChosenStage>& chosen = fidelity_->chosen();
      surface::ModelTimes times;
      message = convert::to_message(surface::make_object_model(
          convert::from_message(shape),
          convert::from_message(shape.has_standing_on() ? shape.standing_on() : shape.table()),
          model_options(node_, chosen), &times));
      message.set_valid(true);
      if (chosen) *message.mutable_fidelity() = chosen->choice;
      add_time(message, "normals", times.normals);
      add_time(message, "poisson", times.poisson);
      add_time(message, "convex_pieces", times.convex_pieces);
      add_time(message, "properties", times.properties);
      if (times.alternatives > 0) add_time(message, "alternatives", times.alternatives);
    });
    if (!problem.empty()) {
      message = msgs::ObjectModel();
      message.set_problem(problem);
    }
    return message;
  }

  void publish(const msgs::CompletedShape& shape) {
    msgs::ObjectModel model = to_model(shape);
    *model.mutable_header() = shape.header();
    model.set_id(shape.id());
    model.set_object_count(shape.object_count());
    model.set_touches_image_border(shape.touches_image_border());
    model.set_occluded_share(shape.occluded_share());
    model.set_confidence(surface::mesh_confidence(shape.confidence(), model.substitute()));
    model.set_method(shape.method());
    model.set_vote(shape.vote());
    *model.mutable_table() = shape.table();
    if (model.valid()) {
      const std::string text = fmt::format(
          "object {}: {} triangles, {}, {} convex pieces, {:.0f} cm^3, {:.2f} mm from what was "
          "seen, {:.0f} % of the surface guessed",
          shape.id(), model.mesh().triangle_count(), model.mesh_defects(),
          model.convex_pieces_size(), model.volume() * 1e6, model.seen_deviation() * 1e3,
          100 * model.guessed_area());
      node_.log_info("{}", text);
      if (!model.substitute().empty()) {
        node_.log_warning("object {}: {}", shape.id(), model.substitute());
      }
      node_.report(graph::Health::kOk, text);
    } else {
      node_.report(graph::Health::kWarning,
                   fmt::format("object {} has no mesh: {}", shape.id(), model.problem()));
    }
    publisher_.publish(std::move(model));
  }

  graph::Node& node_;
  std::optional<nodes::StageFidelity> fidelity_;
  graph::Publisher<msgs::ObjectModel> publisher_;
  graph::Subscription subscription_;
};

void run(graph::Node& node) {
  const PoissonMeshing meshing(node);
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"poisson_meshing",
     "Turns each completed shape into a watertight mesh, convex pieces and mass properties. "
     "Takes /shapes, publishes one message per object on /models (latched, the last 32). A shape "
     "that gives no mesh is published as not valid, with the reason."},
    run);

}  // namespace
