#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "msgs/belief.pb.h"
#include "msgs/camera.pb.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"
#include "msgs/convert/images.h"
#include "msgs/convert/objects.h"
#include "msgs/convert/outcomes.h"
#include "msgs/grasp.pb.h"
#include "msgs/objects.pb.h"
#include "nodes/held_modelling/model_store.h"
#include "nodes/held_picture/held_picture.h"
#include "nodes/platform_source/platform_source.h"
#include "prehend/belief/held_object.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"
#include "prehend/grasp/known/grasp_memory.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"

namespace {

using namespace prehend;

constexpr std::size_t kMostObjects = 32;  // that wait for a late reader
constexpr std::size_t kMostViews = 4;     // that are kept

geometry::Plane support_of(const msgs::CompletedShape& shape) {
  return convert::from_message(shape.has_standing_on() ? shape.standing_on() : shape.table());
}

class HeldModelling {
 public:
  explicit HeldModelling(graph::Node& node)
      : node_(node),
        platform_(declare_platform()),
        patience_(node.declare_parameter<double>({.name = "patience",
                                                  .default_value = 20.0,
                                                  .unit = "s",
                                                  .minimum = 0.1,
                                                  .description = "wall time to wait for a picture",
                                                  .read_only = true})),
        store_(declare_store()),
        models_(
            node.advertise<msgs::ObjectModel>("/held/model", graph::QoS::latched(kMostObjects))),
        pictures_(node, platform_),
        shapes_in_(node.subscribe<msgs::CompletedShape>(
            "/shapes", graph::QoS::latched(kMostObjects),
            [this](const auto& shape) {
              const std::lock_guard lock(mutex_);
              view_of(shape->header().stamp()).shapes[shape->id()] = shape.shared();
            })),
        plans_in_(node.subscribe<msgs::GraspPlan>(
            "/plans", graph::QoS::latched(kMostObjects),
            [this](const auto& plan) {
              const std::lock_guard lock(mutex_);
              view_of(plan->header().stamp()).plans[plan->id()] = plan.shared();
            })),
        models_in_(node.subscribe<msgs::ObjectModel>(
            "/models", graph::QoS::latched(kMostObjects),
            [this](const auto& model) {
              if (!model->has_known()) return;
              const std::lock_guard lock(mutex_);
              view_of(model->header().stamp()).known[model->id()] = model->known().name();
            })),
        results_in_(node.subscribe<msgs::CycleResult>(
            "/cycle/result", graph::QoS::queue(4),
            [this](const auto& result) {
              const std::string problem = node_.shield("store", [&] { ended(*result); });
              if (!problem.empty()) {
                node_.report(graph::Health::kError, "what was seen is not stored: " + problem);
              }
            })),
        look_(node.serve_action<msgs::HeldLookGoal, msgs::HeldLookFeedback, msgs::HeldLookResult>(
            "/held/look", [this](const msgs::HeldLookGoal& goal, Context& context) {
              return look(goal, context);
            })) {}

 private:
  using Context = graph::ActionContext<msgs::HeldLookFeedback>;

  struct View {
    std::map<std::uint32_t, std::shared_ptr<const msgs::CompletedShape>> shapes;
    std::map<std::uint32_t, std::shared_ptr<const msgs::GraspPlan>> plans;
    std::map<std::uint32_t, std::string> known;  // names of those that need not be looked at
  };
  /// The object that was looked at last.
  struct Held {
    std::int64_t stamp = 0;  // ns
    std::uint32_t id = 0;
    std::shared_ptr<const msgs::CompletedShape> shape;
    std::shared_ptr<const msgs::GraspPlan> plan;  // null: it has not come
    belief::HeldObject object;
    std::optional<surface::ObjectModel> model;
    bool stored = false;
  };

  robot::Platform declare_platform() {
    const auto platform = node_.declare_parameter<std::string>(
        {.name = "platform",
         .default_value = "stage_pg70",
         .description = "the robot that holds things (kr5_sdh, pa10_barrett, ...)",
         .read_only = true});
    return robot::read_platform(robot::platform_file(nodes::declare_platforms(node_), platform));
  }

  std::optional<nodes::ModelStore> declare_store() {
    const auto folder = node_.declare_parameter<std::string>(
        {.name = "store",
         .description = "folder that an object which was turned before the camera is stored in as "
                        "a known object, made where it is not there; empty: none is",
         .read_only = true});
    const auto database = node_.declare_parameter<std::string>(
        {.name = "database",
         .description = "file of grasps of known objects that its grasps go to, and how the one "
                        "that was executed went; empty: none",
         .read_only = true});
    if (folder.empty() && !database.empty()) {
      throw geometry::InputError("Parameter database does not apply without store",
                                 "Name a folder for the objects' meshes, or leave it out");
    }
    if (folder.empty()) return std::nullopt;
    return std::make_optional<nodes::ModelStore>(folder, database);
  }

  View& view_of(std::int64_t stamp) {
    View& view = views_[stamp];
    while (views_.size() > kMostViews && views_.begin()->first != stamp) {
      views_.erase(views_.begin());
    }
    return view;
  }

  // The goal's object, begun anew when it is another one. @throws geometry::InputError
  Held& held_of(const msgs::HeldLookGoal& goal) {
    if (held_ && held_->stamp == goal.stamp() && held_->id == goal.object_id()) return *held_;
    const auto view = views_.find(goal.stamp());
    if (view == views_.end() || !view->second.shapes.contains(goal.object_id())) {
      throw geometry::InputError("the view that it was grasped by is not known any more",
                                 "Start held_modelling before the cycle");
    }
    const auto known = view->second.known.find(goal.object_id());
    if (known != view->second.known.end()) {
      throw geometry::InputError("it is the known object " + known->second,
                                 "Nothing: all of it is known");
    }
    const auto shape = view->second.shapes.at(goal.object_id());
    const auto plan = view->second.plans.find(goal.object_id());
    held_.reset();
    held_.emplace(Held{goal.stamp(), goal.object_id(), shape,
                       plan == view->second.plans.end() ? nullptr : plan->second,
                       belief::HeldObject(convert::from_message(*shape), support_of(*shape)),
                       std::nullopt, false});
    return *held_;
  }

  msgs::HeldLookResult look(const msgs::HeldLookGoal& goal, Context& context) {
    msgs::HeldLookResult result;
    const std::string problem = node_.shield("look", [&] { take_look(goal, context, &result); });
    if (!problem.empty()) result.set_text(problem);
    node_.report(result.taken() ? graph::Health::kOk : graph::Health::kWarning, result.text());
    node_.log_info("object {}: {}", goal.object_id(), result.text());
    return result;
  }

  void take_look(const msgs::HeldLookGoal& goal, Context& context, msgs::HeldLookResult* result) {
    const nodes::HeldPicture picture =
        pictures_.take(goal, patience_, [&context] { return context.cancelled(); });
    const std::lock_guard lock(mutex_);
    Held& object = held_of(goal);
    const geometry::PointCloud thought_W =
        geometry::transformed(convert::from_message(*object.shape).cloud_W, picture.X_WO);
    belief::HeldLook look =
        belief::held_look(picture.depth, picture.camera, picture.X_WC,
                          convert::from_message(object.shape->table()), picture.robot_W, thought_W);
    look.X_WO = picture.X_WO;
    const belief::TakenLook taken = object.object.add(look);
    result->set_looks(static_cast<std::uint32_t>(object.object.looks()));
    result->set_moved(taken.moved);
    if (!taken.problem.empty()) {
      result->set_text(taken.problem);
      return;
    }
    object.model = object.object.model();
    result->set_taken(true);
    result->set_guessed_area(object.model->guessed_area);
    result->set_text(fmt::format(
        "{} looks in the hand leave {:.0f} % of it unseen; it lies {:.1f} mm other than it was "
        "gripped by the plan",
        object.object.looks(), 100 * object.model->guessed_area, 1e3 * taken.moved));
    publish(object);
  }

  void publish(const Held& held) {
    msgs::ObjectModel message = convert::to_message(*held.model);
    *message.mutable_header() = held.shape->header();
    message.set_id(held.id);
    message.set_valid(true);
    message.set_object_count(held.shape->object_count());
    *message.mutable_table() = held.shape->table();
    message.set_method("held");
    models_.publish(std::move(message));
  }

  // The cycle has ended: what it held last is known now, with its grasps and how they went.
  void ended(const msgs::CycleResult& result) {
    const std::lock_guard lock(mutex_);
    if (!store_ || !held_ || held_->stored || !held_->model || result.object_id() != held_->id) {
      return;
    }
    std::vector<nodes::ModelStore::Grasp> grasps;
    const bool succeeded =
        convert::from_message(result.outcome()) == control::CycleOutcome::kSucceeded;
    for (int i = 0; held_->plan && i < held_->plan->grasps_size(); ++i) {
      const msgs::Grasp& planned = held_->plan->grasps(i);
      nodes::ModelStore::Grasp grasp;
      grasp.X_WG = convert::from_message(planned.x_wg());
      grasp.stored.joints = {planned.open_position().begin(), planned.open_position().end()};
      grasp.stored.force = planned.grasp_force();
      grasp.stored.quality = planned.quality();
      grasp.stored.score = planned.score();
      if (static_cast<std::uint32_t>(i) == result.grasp_index()) {
        // Closing has moved it in the hand.
        grasp.X_WG = held_->object.X_held().inverse(Eigen::Isometry) * grasp.X_WG;
        grasp.stored.attempts = 1;
        grasp.stored.successes = succeeded ? 1 : 0;
      }
      grasps.push_back(std::move(grasp));
    }
    const std::size_t count = grasps.size();
    const std::filesystem::path file =
        store_->store(held_->model->mesh_W, support_of(*held_->shape),
                      grasp::remembered_as(platform_.hand), std::move(grasps));
    held_->stored = true;
    const std::string text = fmt::format("object {} is known from now on as {}, with {} grasps",
                                         held_->id, file.stem().string(), count);
    node_.log_info("{}: {}", text, file.string());
    node_.report(graph::Health::kOk, text);
  }

  graph::Node& node_;
  robot::Platform platform_;
  double patience_;  // s
  std::optional<nodes::ModelStore> store_;
  std::mutex mutex_;                    // of what follows, as looks come in a thread of their own
  std::map<std::int64_t, View> views_;  // by the stamp [ns]
  std::optional<Held> held_;
  graph::Publisher<msgs::ObjectModel> models_;
  nodes::HeldPictures pictures_;
  graph::Subscription shapes_in_, plans_in_, models_in_, results_in_;
  graph::ActionServer look_;
};

void run(graph::Node& node) {
  const HeldModelling modelling(node);
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"held_modelling",
     "Closes the model of what a hand holds. Asked to look (action /held/look, by the cycle that "
     "turns it before the camera), takes the next picture's depth (/camera/look), leaves the "
     "robot's own links out, lays what is seen onto what was seen before (/shapes) and publishes "
     "the model as it is known then on /held/model. When the cycle ends, the object is stored as a "
     "known one, with its grasps and how they went (store, database)."},
    run);

}  // namespace
