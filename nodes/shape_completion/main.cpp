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
#include "prehend/perception/masks.h"
#include "prehend/shape/scene_completion.h"

namespace {

using namespace prehend;

constexpr double kRadiansPerDegree = 0.017453292519943295;
constexpr std::size_t kMostObjects = 32;  // that wait for a late reader

void declare_parameters(graph::Node& node) {
  const shape::CompletionOptions o;
  node.declare_parameter<int>({.name = "orientations",
                               .default_value = o.orientations,
                               .minimum = 1,
                               .maximum = 181,
                               .description = "of the symmetry plane, odd"});
  node.declare_parameter<double>({.name = "max_angle",
                                  .default_value = o.max_angle / kRadiansPerDegree,
                                  .unit = "deg",
                                  .minimum = 0.1,
                                  .maximum = 90.0,
                                  .description = "of the orientations, to both sides of the "
                                                 "viewing direction"});
  node.declare_parameter<int>({.name = "shifts",
                               .default_value = o.shifts,
                               .minimum = 2,
                               .maximum = 1000,
                               .description = "of the plane along its normal; time grows with it"});
  node.declare_parameter<double>({.name = "thinning",
                                  .default_value = o.thinning,
                                  .minimum = 0.0,
                                  .maximum = 0.2,
                                  .description = "voxel in which one point votes, of the extent; "
                                                 "0: every point votes"});
  node.declare_parameter<double>({.name = "depth_tolerance",
                                  .default_value = o.depth_tolerance,
                                  .unit = "m",
                                  .minimum = 1e-5,
                                  .maximum = 0.1,
                                  .description = "depth differences below this are noise"});
  node.declare_parameter<double>({.name = "max_contradicted",
                                  .default_value = o.max_contradicted,
                                  .minimum = 0.0,
                                  .maximum = 1.0,
                                  .description = "planes that put a greater fraction of points "
                                                 "where the camera looked through are refused"});
  node.declare_parameter<std::string>(
      {.name = "confidence_model",
       .default_value = "",
       .description = "YAML file of coefficients (config/fidelity/shape_confidence.yaml); empty: "
                      "the built-in ones",
       .read_only = true,
       .reads_file = true});
  node.declare_parameter<std::string>(
      {.name = "vote",
       .default_value = "supported",
       .choices = {"supported", "contradiction", "as_published"},
       .description = "contradiction: the published vote alone; supported: with points that "
                      "coincide; as_published: the published method in all its parts"});
  node.declare_parameter<bool>({.name = "second_plane",
                                .default_value = o.second_plane,
                                .description = "mirror at a perpendicular plane too, if there is "
                                               "one that the view does not contradict"});
  node.declare_parameter<int>({.name = "alternatives",
                               .default_value = 2,
                               .minimum = 0,
                               .maximum = 4,
                               .description = "shapes by other planes, nearly as good, that the "
                                              "object may have as well: grasps are tried on them"});
  node.declare_parameter<bool>({.name = "other_methods",
                                .default_value = true,
                                .description = "hand on what the shape would be by other methods, "
                                               "for the belief once it was touched"});
}

shape::CompletionOptions completion_options(const graph::Node& node,
                                            const std::optional<nodes::ChosenStage>& chosen) {
  const auto vote = node.parameter<std::string>("vote");
  const double depth_tolerance = node.parameter<double>("depth_tolerance");
  if (vote == "as_published") {
    shape::CompletionOptions published = shape::as_published();
    published.depth_tolerance = depth_tolerance;
    return published;
  }
  shape::CompletionOptions o;
  if (chosen) {
    o = fidelity::shape_options(chosen->setting).completion;
  } else {
    o.orientations = node.parameter<int>("orientations");
    o.shifts = node.parameter<int>("shifts");
    o.thinning = node.parameter<double>("thinning");
  }
  if (vote == "contradiction") o.vote = shape::VoteKind::kPublished;
  o.second_plane = node.parameter<bool>("second_plane");
  if (!chosen) o.alternatives = node.parameter<int>("alternatives");
  o.other_methods = node.parameter<bool>("other_methods");
  o.max_angle = node.parameter<double>("max_angle") * kRadiansPerDegree;
  o.max_contradicted = node.parameter<double>("max_contradicted");
  o.depth_tolerance = depth_tolerance;
  return o;
}

shape::ConfidenceModel confidence_model(const graph::Node& node) {
  const auto file = node.parameter<std::string>("confidence_model");
  return file.empty() ? shape::ConfidenceModel{} : shape::read_confidence_model(file);
}

class ShapeCompletion {
 public:
  explicit ShapeCompletion(graph::Node& node) : node_(node) {
    declare_parameters(node);
    confidence_model_ = confidence_model(node);
    fidelity_.emplace(
        node, fidelity::Stage::kShape,
        std::vector<std::string>{"orientations", "shifts", "thinning", "alternatives"});
    publisher_ = node.advertise<msgs::CompletedShape>("/shapes", graph::QoS::latched(kMostObjects));
    subscription_ = node.subscribe<msgs::ObjectHypotheses>(
        "/objects", graph::QoS::queue(4),
        [this](const graph::Received<msgs::ObjectHypotheses>& message) { complete_all(*message); });
  }

 private:
  void complete_all(const msgs::ObjectHypotheses& message) {
    if (message.objects_size() == 0) {
      node_.report(graph::Health::kWarning, "nothing to complete: " + message.problem());
      return;
    }
    perception::SegmentedScene scene;
    const std::string damage = node_.shield("objects", [&] {
      scene = convert::from_message(message);
      perception::find_occlusions(scene);
    });
    if (!damage.empty()) {
      node_.report(graph::Health::kError, "objects are damaged: " + damage);
      return;
    }
    int completed = 0;
    std::string problem;
    std::vector<shape::SceneShape> shapes(scene.objects.size());
    try {
      shapes = shape::complete_scene(scene, completion_options(node_, fidelity_->chosen()),
                                     confidence_model_);
    } catch (const std::exception&) {
      for (shape::SceneShape& shape : shapes) shape.error = std::current_exception();
    }
    for (std::size_t i = 0; i < shapes.size(); ++i) {
      const perception::ObjectHypothesis& object = scene.objects[i];
      msgs::CompletedShape shape = message_of(scene, object, shapes[i]);
      *shape.mutable_header() = message.header();
      shape.set_object_count(static_cast<std::uint32_t>(scene.objects.size()));
      if (shape.completed()) {
        ++completed;
        node_.log_info(
            "object {}: {} seen points became {} by {}, vote {:.4f}, confidence {:.2f}{}{}",
            object.id, object.cloud_W.size(), shape.cloud().count(), shape.method(), shape.vote(),
            shape.confidence(), shape.evidence().open_vessel() ? ", an open vessel" : "",
            shape.refused().empty() ? "" : "; refused: " + shape.refused());
      } else {
        problem = fmt::format("; object {}: {}", object.id, shape.problem());
      }
      publisher_.publish(std::move(shape));
    }
    node_.report(
        problem.empty() ? graph::Health::kOk : graph::Health::kWarning,
        fmt::format("{} of {} objects completed{}", completed, scene.objects.size(), problem));
  }

  msgs::CompletedShape message_of(const perception::SegmentedScene& scene,
                                  const perception::ObjectHypothesis& object,
                                  const shape::SceneShape& completed) {
    msgs::CompletedShape message;
    const std::string problem = node_.shield(fmt::format("object {}", object.id), [&] {
      message = convert::to_message(completed.get());
      if (fidelity_->chosen()) *message.mutable_fidelity() = fidelity_->chosen()->choice;
    });
    if (!problem.empty()) {
      message = msgs::CompletedShape();
      message.set_problem(problem);
      *message.mutable_cloud() = convert::to_message(object.cloud_W);
      message.set_origin(std::string(object.cloud_W.size(), '\0'));
      *message.mutable_viewpoint() = convert::to_message(Eigen::Vector3d(scene.X_WC.translation()));
    }
    message.set_id(static_cast<std::uint32_t>(object.id));
    *message.mutable_table() = convert::to_message(scene.table_W);
    if (object.support_W) {
      *message.mutable_standing_on() = convert::to_message(*object.support_W);
    }
    message.set_touches_image_border(object.touches_image_border);
    message.set_occluded_share(object.occluded_share);
    msgs::StageTime* time = message.add_times();
    time->set_stage("completion");
    time->set_seconds(completed.seconds);
    return message;
  }

  graph::Node& node_;
  shape::ConfidenceModel confidence_model_;
  std::optional<nodes::StageFidelity> fidelity_;
  graph::Publisher<msgs::CompletedShape> publisher_;
  graph::Subscription subscription_;
};

void run(graph::Node& node) {
  const ShapeCompletion completion(node);
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"shape_completion",
     "Predicts the unseen side of each object by the plane of symmetry that contradicts the view "
     "least; where every plane does, by rotation, extrusion or the convex hull. Takes /objects, "
     "publishes one message per object on /shapes (latched, the "
     "last 32). An object that cannot be completed is published as seen, with the reason."},
    run);

}  // namespace
