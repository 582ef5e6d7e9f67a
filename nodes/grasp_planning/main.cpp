#include <algorithm>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"
#include "msgs/convert/load_bounds.h"
#include "msgs/convert/objects.h"
#include "msgs/convert/outcomes.h"
#include "nodes/grasp_planning/grasp_records.h"
#include "nodes/grasp_planning/made_pushes.h"
#include "nodes/grasp_planning/model_batch.h"
#include "nodes/grasp_planning/placed_objects.h"
#include "nodes/grasp_planning/planner_parameters.h"
#include "nodes/grasp_planning/touch_parameters.h"
#include "nodes/gripper_source/gripper_source.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"

namespace {

using namespace prehend;
using std::chrono::steady_clock;

// Where the candidates fell, and how near the best of them came.
void log_ledger(graph::Node& node, const msgs::GraspPlan& plan) {
  for (const auto& rejection : plan.rejections()) {
    node.log_info("  {} of {} ({}): {}{}", rejection.count(), plan.candidates(),
                  rejection.generator(), rejection.reason(),
                  rejection.nearest_miss().empty() ? "" : ", at best " + rejection.nearest_miss());
  }
  for (const auto& remedy : plan.remedies()) node.log_info("  it would help: {}", remedy.text());
  for (const std::string& one : plan.remedies_in_vain()) {
    node.log_info("  it would not help: {}", one);
  }
  if (plan.remedies_incomplete()) node.log_info("  more was not tried within remedy_budget");
}

std::optional<nodes::GraspRecords> declare_records(graph::Node& node) {
  const auto file = node.declare_parameter<std::string>(
      {.name = "database",
       .description = "file of grasps of known objects (known_objects): used, added to, and told "
                      "what was executed; empty: none",
       .read_only = true});
  if (file.empty()) return std::nullopt;
  return std::make_optional<nodes::GraspRecords>(file);
}

class GraspPlanning {
 public:
  explicit GraspPlanning(graph::Node& node)
      : node_(node),
        platform_(nodes::declare_platform(node)),
        gripper_(node),
        approach_(node.declare_parameter<std::string>(
            {.name = "approach",
             .default_value = "auto",
             .choices = {"auto", "down", "table", "any"},
             .description =
                 "directions to approach along: down the world's z axis, straight at the "
                 "table, any; auto: any, or the one that the platform can",
             .read_only = true})),
        records_(declare_records(node)),
        workspace_(node.declare_parameter<double>(
            {.name = "workspace",
             .default_value = 0.0,
             .unit = "m",
             .minimum = 0.0,
             .description = "half the side of the square in which the hand may be, 0: no limit",
             .read_only = true})),
        batch_(std::chrono::duration<double>(node.declare_parameter<double>(
            {.name = "patience",
             .default_value = 15.0,
             .unit = "s",
             .minimum = 0.0,
             .description = "wall time to wait for the next model of a view",
             .read_only = true}))),
        plans_(node.advertise<msgs::GraspPlan>("/plans", graph::QoS::latched(32))),
        models_(node.subscribe<msgs::ObjectModel>("/models", graph::QoS::latched(32),
                                                  [this](const auto& model) {
                                                    batch_.add(model.shared(), steady_clock::now());
                                                    plan_ready();
                                                  })),
        results_(node.subscribe<msgs::CycleResult>("/cycle/result", graph::QoS::queue(4),
                                                   [this](const auto& result) {
                                                     placed_.clear();
                                                     pushes_.clear();
                                                     record(*result);
                                                   })),
        timer_(node.create_timer(0.25, [this] { plan_ready(); })) {
    if (platform_->says_its_gripper()) {
      gripper_.listen([this] { plan_ready(); });
    } else if (gripper_.model()) {
      throw geometry::InputError("Parameter gripper does not apply: the platform has its own hand",
                                 "Give one of the two");
    }
    if (platform_->inspects() || platform_->looks()) {
      camera_ = node_.subscribe<msgs::CameraInfo>(
          "/camera/info", graph::QoS::latched(), [this](const auto& camera) {
            node_.shield("camera", [&] { platform_->view_by(*camera); });
          });
    }
    put_down_ = node_.subscribe<msgs::ObjectModel>(
        "/placed", graph::QoS::latched(64), [this](const auto& model) {
          pushes_.something_was_put_down();
          node_.shield("what was put down is left out as an obstacle",
                       [&] { placed_.add(*model, picked(*model)); });
        });
    states_ =
        node_.subscribe<msgs::CycleState>("/cycle/state", graph::QoS::queue(64),
                                          [this](const auto& state) { pushes_.begun(*state); });
    joints_ = node_.subscribe<msgs::JointState>(
        "/joint_states", graph::QoS::latest(),
        [this](const auto& state) { platform_->start_from(*state); });
  }

 private:
  void record(const msgs::CycleResult& result) {
    if (!records_) return;
    const std::string recorded = records_->record(result, platform_->hand());
    if (!recorded.empty()) node_.log_info("{}", recorded);
  }

  void plan_ready() {
    // Until the robot has said what it has. Two that differ are each object's problem.
    const std::optional<robot::GripperModel> said = gripper_.model();
    if (said && platform_->says_its_gripper()) platform_->set_gripper(*said);
    if (platform_->says_its_gripper() && !said && gripper_.problem().empty()) {
      if (!batch_.models().empty()) {
        node_.report(graph::Health::kWarning, "waiting to plan: " + gripper_.missing());
      }
      return;
    }
    const auto ready = batch_.take_ready(steady_clock::now());
    if (!ready.empty() && batch_.incomplete()) {
      node_.report(graph::Health::kWarning,
                   fmt::format("planning with {} of {} models of the view as obstacles",
                               batch_.models().size(), ready.front()->object_count()));
    }
    if (!ready.empty()) {
      read_obstacles();
      remedy_budget_left_ = platform_->remedy_budget();
    }
    for (const auto& model : ready) {
      if (!node_.ok()) return;  // asked to end meanwhile
      plans_.publish(plan(*model));
    }
  }

  // What was put down, as the view had it; null where that is no more the newest.
  const planning::Neighbours* picked(const msgs::ObjectModel& model) const {
    const auto now = batch_.models().find(model.id());
    const auto was = obstacles_.find(model.id());
    const bool is_of_view = now != batch_.models().end() && was != obstacles_.end() &&
                            now->second->header().stamp() == model.header().stamp();
    return is_of_view ? &was->second : nullptr;
  }

  // What the view's objects are to each other. One that cannot be read is no obstacle, and is said.
  void read_obstacles() {
    obstacles_.clear();
    for (const auto& [id, model] : batch_.models()) {
      if (!model->valid()) continue;
      node_.shield(fmt::format("object {} is left out as an obstacle", id),
                   [&, id = id] { obstacles_[id] = nodes::neighbour_of(*model); });
    }
  }

  grasp::Reachability reachability(const geometry::Plane& table) const {
    grasp::Reachability result;
    if (approach_ == "down") result.approach_W = -Eigen::Vector3d::UnitZ();
    if (approach_ == "table") result.approach_W = -table.normal;
    if (workspace_ > 0) {
      const double infinity = std::numeric_limits<double>::infinity();
      result.workspace_W = {Eigen::Vector3d(-workspace_, -workspace_, -infinity),
                            Eigen::Vector3d(workspace_, workspace_, infinity)};
    }
    return result;
  }

  // Whatever is wrong with one object is its own problem: the others are planned all the same.
  msgs::GraspPlan plan_alone(const msgs::ObjectModel& message) {
    msgs::GraspPlan plan;
    const std::string failure =
        node_.shield(fmt::format("object {}", message.id()), [&] { plan = plan_on(message); });
    if (failure.empty()) return plan;
    plan = msgs::GraspPlan();
    plan.set_outcome(msgs::GraspPlan::FAILED);
    plan.set_problem("planning failed: " + failure);
    return plan;
  }

  // A model that makes no sense is an answer; other exceptions are failures of planning.
  msgs::GraspPlan plan_on(const msgs::ObjectModel& message) {
    const auto without_grasps = [](msgs::GraspPlan::Outcome outcome, const std::string& problem) {
      msgs::GraspPlan plan;
      plan.set_outcome(outcome);
      plan.set_problem(problem);
      return plan;
    };
    if (!message.valid()) {
      return without_grasps(msgs::GraspPlan::UNGRASPABLE,
                            "no shape was predicted: " + message.problem());
    }
    if (platform_->says_its_gripper() && !gripper_.model()) {
      return without_grasps(msgs::GraspPlan::FAILED, "planning failed: " + gripper_.problem());
    }
    try {
      const geometry::Plane table = convert::from_message(message.table());
      const surface::ObjectModel object = convert::from_message(message);
      const auto known = nodes::GraspRecords::known(message);
      grasp::GraspDatabase* database = records_ && known ? &records_->database() : nullptr;
      return platform_->plan(object, table, neighbours_of(message), reachability(table), database,
                             known, convert::load_of(message), probes_of(message),
                             message.confidence() > 0 ? std::min(message.confidence(), 1.0) : 0.0,
                             pushes_.lines(), remedy_budget_left_);
    } catch (const geometry::InputError& error) {
      return without_grasps(msgs::GraspPlan::UNGRASPABLE, error.what());
    }
  }

  static std::vector<planning::ProbeWay> probes_of(const msgs::ObjectModel& message) {
    std::vector<planning::ProbeWay> ways;
    for (const msgs::ProbeMotion& probe : message.probes()) {
      ways.push_back({convert::from_message(probe.start()), convert::from_message(probe.at()),
                      probe.radius(), probe.gain()});
    }
    return ways;
  }

  planning::Neighbours neighbours_of(const msgs::ObjectModel& message) const {
    planning::Neighbours all = placed_.unseen(obstacles_);
    for (const auto& [id, own] : obstacles_) {
      if (id == message.id()) continue;
      all.meshes_W.insert(all.meshes_W.end(), own.meshes_W.begin(), own.meshes_W.end());
      all.pieces_W.insert(all.pieces_W.end(), own.pieces_W.begin(), own.pieces_W.end());
    }
    return all;
  }

  msgs::GraspPlan plan(const msgs::ObjectModel& message) {
    const auto start = steady_clock::now();
    msgs::GraspPlan plan = plan_alone(message);
    const double seconds = std::chrono::duration<double>(steady_clock::now() - start).count();
    for (const auto& time : plan.times()) {
      if (time.stage() != nodes::kRemediesStage) continue;
      remedy_budget_left_ = std::max(0.0, remedy_budget_left_ - time.seconds());
    }
    *plan.mutable_header() = message.header();
    plan.set_id(message.id());
    plan.set_object_count(message.object_count());
    *plan.mutable_centroid() = message.centroid();
    if (gripper_.model()) *plan.mutable_gripper() = gripper_.description();
    auto& time = *plan.add_times();
    time.set_stage("grasp_planning");
    time.set_seconds(seconds);
    const grasp::PlanAnswer answer = convert::answer_of(plan);
    if (answer.outcome == grasp::PlanOutcome::kGraspable) {
      node_.log_info(
          "object {}: {} grasps of {} candidates, best score {:.2f}{}, {:.2f} s", plan.id(),
          plan.grasps_size(), plan.candidates(), plan.grasps(0).score(),
          plan.grasps(0).has_robustness() ? "" : std::string(" (") + grasp::kNotAssessed + ")",
          seconds);
      for (const msgs::Choice& choice : plan.choices()) node_.log_info("  {}", choice.text());
      if (plan.has_probe() && plan.probe().arm_size() == 0) {
        node_.log_info("  no probe: {}", plan.probe().remark());
      }
    } else {
      node_.log_info("object {}: {} ({:.2f} s)", plan.id(), grasp::in_words(answer), seconds);
    }
    if (plan.has_push() && plan.push().arm_size() == 0) {
      node_.log_info("  no push: {}", plan.push().remark());
    }
    pushes_.planned(plan);
    log_ledger(node_, plan);
    nodes::log_touch(node_, plan);
    if (records_) {
      node_.shield("record of object " + std::to_string(plan.id()),
                   [&] { records_->planned(message, plan); });
    }
    return plan;
  }

  graph::Node& node_;
  std::unique_ptr<nodes::PlatformPlanning> platform_;
  nodes::GripperSource gripper_;
  std::string approach_;
  std::optional<nodes::GraspRecords> records_;
  double workspace_;
  nodes::ModelBatch batch_;
  std::map<std::uint32_t, planning::Neighbours> obstacles_;  // of the view, by object
  double remedy_budget_left_ = 0;                            // s, of the view
  graph::Publisher<msgs::GraspPlan> plans_;
  graph::Subscription models_;
  nodes::PlacedObjects placed_;
  nodes::MadePushes pushes_;
  graph::Subscription results_, joints_, camera_, put_down_, states_;
  graph::Node::Timer timer_;
};

void run(graph::Node& node) {
  GraspPlanning planning(node);
  node.spin();
}

const prehend::graph::RegisteredNodeProgram registered(
    {"grasp_planning",
     "Plans grasps of predicted objects (/models) and the motions of the arm that carries the "
     "hand, and publishes ranked lists (/plans), with the reason and count of everything that was "
     "rejected. The other "
     "objects of the view are obstacles.",
     10},  // s: the object that it plans on is finished
    run);

}  // namespace
