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
#include "nodes/grasp_planning/misfit_parameters.h"
#include "nodes/grasp_planning/model_batch.h"
#include "nodes/grasp_planning/platform_planning.h"
#include "nodes/grasp_planning/touch_parameters.h"
#include "nodes/gripper_source/gripper_source.h"
#include "nodes/platform_source/platform_source.h"
#include "nodes/task_source/task_source.h"
#include "prehend/fidelity/plan_settings.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/knob_parameters.h"
#include "prehend/graph/node_program.h"
#include "prehend/grasp/generators/generator_registry.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/tree_file.h"

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

// Says which plug-ins are there but cannot be chosen.
template <class Registry>
std::vector<std::string> usable_names(graph::Node& node, const Registry& registry) {
  for (const auto& problem : registry.problems()) {
    node.log_warning("{} cannot be used: {}", problem.file.string(), problem.reason);
  }
  return registry.names();
}

// The defaults are those that `options` have.
void declare_planner_options(graph::Node& node, grasp::PlannerOptions* declared) {
  grasp::PlannerOptions& options = *declared;
  const graph::DeclareKnobs declare{node};
  grasp::PlannerOptions::knobs(options, declare);
  grasp::PadOptions::knobs(options.pads, declare);
  grasp::FingerOptions::knobs(options.fingers, declare);
  const auto generators = node.declare_parameter<std::vector<std::string>>(
      {.name = "generators",
       .choices = usable_names(node, grasp::GeneratorRegistry()),
       .description =
           "ways to make candidates, these alone; none: circles and boxes for a parallel gripper, "
           "circles for other hands, and antipodal where none of those holds; others in shared "
           "libraries in PREHEND_GENERATORS",
       .read_only = true});
  if (!generators.empty()) {
    options.generators = generators;
    options.further_generators.clear();
  }
  const auto front = node.declare_parameter<std::string>(
      {.name = "front",
       .description =
           "measured front from which a budget chooses generators, rolls, standoffs and robustness "
           "samples, which must not be given then: of plans of a parallel gripper, or of the whole "
           "chain from images (config/fidelity/chain.yaml, chain_hand.yaml), whose budget counts "
           "the stages before; empty: config/fidelity/plan.yaml of a parallel gripper; none: no "
           "front",
       .read_only = true,
       .reads_file = true});
  node.declare_parameter<double>(
      {.name = "tolerance",
       .default_value = 0.0,
       .unit = "m",
       .minimum = 0.0,
       .description =
           "with the front of a chain, instead of a budget: mean error of its meshes; the "
           "fastest setting that keeps it",
       .read_only = true});
  options.candidates.circles.rolls =
      node.declare_parameter<int>({.name = "rolls",
                                   .default_value = options.candidates.circles.rolls,
                                   .minimum = 1,
                                   .description = "over half a turn",
                                   .read_only = true});
  options.candidates.circles.standoffs =
      node.declare_parameter<int>({.name = "standoffs",
                                   .default_value = options.candidates.circles.standoffs,
                                   .minimum = 1,
                                   .description = "depths of the fingertips tried",
                                   .read_only = true});
  if (node.is_parameter_given("rolls")) {
    options.candidates.rolls = options.candidates.circles.rolls;
  }
  if (node.is_parameter_given("standoffs")) {
    options.candidates.standoffs = options.candidates.circles.standoffs;
  }
}

// None where neither a budget nor a tolerance asks for one. Of a hand a budget alone ends its
// planning: there is no default front.
std::optional<fidelity::Front> front_to_choose_from(const graph::Node& node,
                                                    const robot::Platform& platform,
                                                    const grasp::PlannerOptions& options) {
  auto file = node.parameter<std::string>("front");
  const bool has_tolerance = node.parameter<double>("tolerance") > 0;
  if (!(options.budget > 0) && !has_tolerance) return std::nullopt;
  if (file.empty() && platform.hand.gripper) file = text::tree_file("config/fidelity/plan.yaml");
  if (!file.empty() && file != "none") return fidelity::read_front(file);
  if (!has_tolerance) return std::nullopt;
  throw geometry::InputError("A tolerance is given without the front of a chain to choose from",
                             "Give front, as config/fidelity/chain.yaml");
}

std::unique_ptr<nodes::PlatformPlanning> declare_platform(graph::Node& node) {
  const auto file = node.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "stage_pg70",
       .description = "the robot, its name (stage_pg70, kr5_sdh, pa10_barrett, ...) or file",
       .read_only = true});
  const std::string folder = nodes::declare_platforms(node);
  const auto home = node.declare_parameter<std::string>(
      {.name = "home",
       .default_value = "home",
       .description = "of the platform: where its arm stands when a motion starts",
       .read_only = true});
  robot::Platform platform = robot::read_platform(robot::platform_file(folder, file));
  for (const std::string& remark : platform.model.remarks) node.log_warning("{}", remark);
  planning::PlatformPlanOptions options(platform.hand);
  declare_planner_options(node, &options.grasps);
  planning::PlatformPickOptions& arm = options.arm;
  options.place.given_W = planning::read_place(node.declare_parameter<std::string>(
      {.name = "place",
       .description = "x,y of the world [m] where the object is put; empty: a free "
                      "place is chosen",
       .read_only = true}));
  control::Task task = nodes::declare_task(node);
  planning::PlatformPickOptions::knobs(arm, graph::DeclareKnobs{node, "arm_"});
  options.remedies.budget = 3;
  planning::RemedyOptions::knobs(options.remedies, graph::DeclareKnobs{node});
  planning::DecisionOptions::knobs(options.decision, graph::DeclareKnobs{node, "decide_"});
  planning::DecisionOptions::look_knobs(options.decision, graph::DeclareKnobs{node, "decide_"});
  planning::HeldViewOptions::knobs(options.views, graph::DeclareKnobs{node, "held_view_"});
  planning::ViewOptions::knobs(options.look, graph::DeclareKnobs{node, "look_"});
  nodes::refuse_views(node, task, platform);
  arm.pick.planner = node.declare_parameter<std::string>(
      {.name = "path_planner",
       .default_value = arm.pick.planner,
       .choices = usable_names(node, motion::PlannerRegistry()),
       .description = "finds the arm's free paths (docs/planning.md); others in "
                      "shared libraries in PREHEND_PLANNERS",
       .read_only = true});
  arm.checker = node.declare_parameter<std::string>(
      {.name = "collision_checker",
       .default_value = arm.checker,
       .choices = usable_names(node, motion::CheckerRegistry()),
       .description = "balls: those that hold the links, with vectors; else the "
                      "links' own shapes by that library, slower; others in shared libraries in "
                      "PREHEND_CHECKERS",
       .read_only = true});
  options.motions =
      node.declare_parameter<int>({.name = "motions",
                                   .default_value = options.motions,
                                   .minimum = 1,
                                   .description = "grasps that get a motion of the arm",
                                   .read_only = true});
  options.finer = node.declare_parameter<int>(
      {.name = "finer",
       .default_value = options.finer,
       .minimum = 1,
       .maximum = 10,
       .description = "times as many steps of candidates, once, where hand and arm can execute no "
                      "grasp of the usual ones; 1: they are not tried",
       .read_only = true});
  const nodes::TouchParameters touch = nodes::declare_touch(node);
  options.touch = touch.options;
  options.grip_force = nodes::declare_grip_force(node);
  nodes::refuse_touch_parameters(node, platform);
  const std::optional<fidelity::Front> front = front_to_choose_from(node, platform, options.grasps);
  nodes::refuse_what_does_not_apply(node, platform, front ? &*front : nullptr);
  if (front) {
    node.log_info("chosen from {}: {}", node.parameter<std::string>("front"),
                  fidelity::apply_plan_front(*front, options.grasps.budget,
                                             node.parameter<double>("tolerance"), &options.grasps));
  }
  return std::make_unique<nodes::PlatformPlanning>(std::move(platform), home, std::move(options),
                                                   touch.chosen, std::move(task));
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
        platform_(declare_platform(node)),
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
        results_(
            node.subscribe<msgs::CycleResult>("/cycle/result", graph::QoS::queue(4),
                                              [this](const auto& result) { record(*result); })),
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

  // What the view's objects are to each other. One that cannot be read is no obstacle, and is said.
  void read_obstacles() {
    obstacles_.clear();
    for (const auto& [id, model] : batch_.models()) {
      if (!model->valid()) continue;
      node_.shield(fmt::format("object {} is left out as an obstacle", id), [&, id = id] {
        planning::Neighbours own;
        own.meshes_W.push_back(convert::from_message(model->mesh()));
        for (const auto& piece : model->convex_pieces()) {
          own.pieces_W.push_back(convert::from_message(piece));
        }
        obstacles_[id] = std::move(own);
      });
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
                             remedy_budget_left_);
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
    planning::Neighbours all;
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
  graph::Subscription results_, joints_, camera_;
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
