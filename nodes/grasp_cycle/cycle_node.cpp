#include "nodes/grasp_cycle/cycle_node.h"

#include <algorithm>
#include <limits>
#include <span>
#include <stdexcept>
#include <utility>

#include "msgs/convert/belief.h"
#include "msgs/convert/cycle.h"
#include "msgs/convert/geometry.h"
#include "msgs/convert/load.h"
#include "msgs/convert/outcomes.h"
#include "msgs/convert/percepts.h"
#include "nodes/platform_source/platform_source.h"
#include "nodes/task_source/task_source.h"
#include "prehend/graph/knob_parameters.h"
#include "prehend/graph/node_program.h"
#include "prehend/robot/platform.h"
#include "prehend/robot/robot_files.h"

namespace prehend::nodes {
namespace {

using control::CycleOutcome;
using std::chrono::steady_clock;

constexpr double kPeriod = 0.01;                             // s, of the control loop
constexpr auto kExitDelay = std::chrono::milliseconds(500);  // for the last messages
constexpr double kSameObject = 0.04;                         // m, between an object's centroids
constexpr auto kRobotPatience = std::chrono::seconds(20);    // for the robot to say what it has

bool declare_flag(graph::Node& node, const std::string& name, const std::string& description) {
  return node.declare_parameter<bool>(
      {.name = name, .default_value = false, .description = description, .read_only = true});
}

/// What has to do with no robot.
control::SharedCycleOptions declare_shared_options(graph::Node& node) {
  control::SharedCycleOptions options;
  options.task = declare_task(node);
  control::SharedCycleOptions::knobs(options, graph::DeclareKnobs{node});
  control::SurpriseTolerances::knobs(options.tolerances, graph::DeclareKnobs{node, "surprise_"});
  options.largest_attempts =
      node.declare_parameter<int>({.name = "largest_attempts",
                                   .default_value = options.largest_attempts,
                                   .minimum = 1,
                                   .description = "grasps of an object tried before giving it up",
                                   .read_only = true});
  return options;
}

}  // namespace

CycleNode::CycleNode(graph::Node& node)
    : node_(node),
      object_(node.declare_parameter<int>(
          {.name = "object",
           .default_value = -1,
           .minimum = -1,
           .description =
               "id of the object to grasp, -1: the one with the best grasp, and another one "
               "after an attempt that failed as the hand met it too early; what is set counts from "
               "the next start of the cycle"})),
      grasp_(node.declare_parameter<int>(
          {.name = "grasp",
           .default_value = -1,
           .minimum = -1,
           .description = "rank of the grasp of `object` that is tried first, from 0, whatever the "
                          "plan advises; -1: as the plan has it; what is set counts from the next "
                          "start of the cycle"})),
      exits_(declare_flag(node, "exit_when_done", "end the process after the result")),
      ungraspable_is_ok_(
          declare_flag(node, "ungraspable_is_ok", "exit code 0 when nothing can be grasped")),
      predicted_(node),
      gripper_(node),
      look_(node),
      views_(std::chrono::duration<double>(
          node.declare_parameter<double>({.name = "patience",
                                          .default_value = 20.0,
                                          .unit = "s",
                                          .minimum = 0.0,
                                          .description = "wall time to wait for the next plan of "
                                                         "a view",
                                          .read_only = true}))),
      robot_(declare_robot()),
      emergency_(node, true, EmergencyStopListener::kSilenceOfNothingReal),  // drivers mind theirs
      surprises_(node.advertise<msgs::Surprise>("/surprise", graph::QoS::latched(32))),
      states_(node.advertise<msgs::CycleState>("/cycle/state", graph::QoS::latched(64))),
      results_(node.advertise<msgs::CycleResult>("/cycle/result", graph::QoS::latched(1))),
      tasks_(node.advertise<msgs::Task>("/cycle/task", graph::QoS::latched(1))),
      evidence_(node.advertise<msgs::AttemptEvidence>("/cycle/evidence", graph::QoS::latched(32))),
      percepts_(node.advertise<msgs::ActPercepts>("/cycle/percepts", graph::QoS::latched(32))),
      placed_(node.advertise<msgs::ObjectModel>("/placed", graph::QoS::latched(64))) {
  tasks_.publish(convert::to_message(task_, node_.clock().now()));
  predicted_.listen();
  subscribe();
  timer_ = node.create_timer(kPeriod, [this] { tick(); });
}

std::unique_ptr<ArmRobot> CycleNode::declare_robot() {
  const auto platform = node_.declare_parameter<std::string>(
      {.name = "platform",
       .default_value = "stage_pg70",
       .description = "the robot that the plans are for (stage_pg70, kr5_sdh, ...)",
       .read_only = true});
  const std::string platforms = declare_platforms(node_);
  const auto driver = node_.declare_parameter<std::string>(
      {.name = "gripper_driver",
       .default_value = kSimulated,
       .choices = {kSimulated, "pg70", kSdh, kBarrett},
       .description =
           "who drives the gripper or hand: with a driver, the platform must be one whose "
           "hand is moved as it offers, pg70 through /gripper, sdh and barrett through "
           "/hand",
       .read_only = true});
  const int touch_counts = node_.declare_parameter<int>({.name = "touch_counts",
                                                         .default_value = robot::kTouchCounts,
                                                         .minimum = 0,
                                                         .description = "above: a texel is touched",
                                                         .read_only = true});
  control::SharedCycleOptions shared = declare_shared_options(node_);
  shared.look_timeout = look_.timeout();
  // Predicted objects in a simulation are seen by nobody, but it says where they are.
  shared.only_seen_again = predicted_.wanted();
  task_ = shared.task;
  ArmRobotOptions options{declare_arm_options(node_), declare_pad_gripper_options(node_),
                          touch_counts, false};
  options.view_after_lift = declare_flag(
      node_, "view_after_lift",
      "have the graph's camera look at what was lifted (/percepts/view, of the node belief), which "
      "takes as long as a picture and its depth do: how surprising it looks is said, and changes "
      "nothing; not by a camera that the arm carries");
  static_cast<control::SharedCycleOptions&>(options.cycle) = shared;
  const robot::Platform robot = robot::read_platform(robot::platform_file(platforms, platform));
  refuse_what_does_not_apply(node_, robot, driver);
  for (const char* name : {"push_force", "largest_pushes"}) {
    if (task_.does(control::Primitive::kPush) || !node_.is_parameter_given(name)) continue;
    throw std::invalid_argument(fmt::format(
        "parameter '{}' does not apply with the task {}: it pushes nothing; leave it out", name,
        task_.name));
  }
  if (robot.hand_port == robot::HandPort::kGripper) {
    gripper_.listen();
  } else if (gripper_.model()) {
    throw std::invalid_argument("parameter 'gripper' does not apply with platform " + robot.name +
                                ": it has its own hand; leave it out");
  }
  return std::make_unique<ArmRobot>(node_, robot, gripper_, options);
}

void CycleNode::subscribe() {
  using graph::QoS;
  subscriptions_.push_back(node_.subscribe<msgs::GraspPlan>(
      "/plans", QoS::latched(32),
      [this](const auto& plan) { views_.add(plan.shared(), steady_clock::now()); }));
  subscriptions_.push_back(node_.subscribe<msgs::ObjectModel>(
      "/models", QoS::latched(32), [this](const auto& model) { views_.add(model.shared()); }));
  subscriptions_.push_back(node_.subscribe<msgs::ObjectHypotheses>(
      "/objects", QoS::latched(),
      [this](const auto& objects) { views_.add(*objects, steady_clock::now()); }));
  start_service_ =
      node_.serve<msgs::Empty, msgs::Acknowledge>("/cycle/start", [this](const msgs::Empty&) {
        msgs::Acknowledge answer;
        const std::string stopped = emergency_.refusal();
        answer.set_success(!running_ && !preparing_ && stopped.empty());
        if (!answer.success()) {
          answer.set_reason(stopped.empty() ? "a cycle is running" : stopped);
        } else {
          armed_ = true;
          answer.set_reason("starts on the newest plans");
        }
        return answer;
      });
  stop_service_ =
      node_.serve<msgs::Empty, msgs::Acknowledge>("/cycle/stop", [this](const msgs::Empty&) {
        msgs::Acknowledge answer;
        answer.set_success(running_ || armed_ || preparing_);
        if (!answer.success()) answer.set_reason("no cycle is running");
        if (running_) {
          robot_->cycle().abort("stopped by /cycle/stop");
        } else if (answer.success()) {
          armed_ = false;
          fail("stopped by /cycle/stop");
        }
        return answer;
      });
}

void CycleNode::tick() {
  if (exit_time_ && steady_clock::now() >= *exit_time_) return node_.shutdown();
  if (running_) {
    // It is no failed attempt, after which another follows: the task ends where everything stands.
    if (const std::string why = emergency_.refusal(); !why.empty()) robot_->cycle().abort(why);
    // A step that cannot be done is no reason to let things move on.
    const std::string failure = node_.shield("cycle", [this] {
      predicted_.watch();
      if (robot_->cycle().finished()) return;
      robot_->step();
      publish_evidence();
      publish_percepts();
      publish_placed();
      if (const auto since = robot_->cycle().looks_since()) look_again(*since);
    });
    if (!failure.empty()) robot_->cycle().abort("a step of the cycle failed: " + failure);
    publish_progress();
    if (robot_->cycle().finished()) finish(robot_->cycle().result());
    return;
  }
  if (!armed_ || preparing_) return;
  const View* view = views_.newest_ready(steady_clock::now());
  if (!view || waits_for_robot()) return;
  armed_ = false;
  if (const std::string why = emergency_.refusal(); !why.empty()) return fail(why);
  const std::string failure = node_.shield("plan", [&] { start(*view); });
  if (!failure.empty()) fail(failure);
}

bool CycleNode::waits_for_robot() {
  const std::string missing = robot_->waits_for();
  const auto now = steady_clock::now();
  if (missing.empty()) {
    robot_patience_.reset();
    return false;
  }
  if (!robot_patience_) {
    robot_patience_ = now + kRobotPatience;
    node_.report(graph::Health::kWarning, "waiting: " + missing);
  }
  return now < *robot_patience_;
}

Target CycleNode::target_in(const View& view, int object) const {
  return choose_target(
      view, object, [this](const msgs::Grasp& g) { return robot_->lacks(g); },
      [this](const msgs::GraspPlan& plan) { return is_settled(plan); },
      [this](const msgs::GraspPlan& plan) { return is_among(failed_W_, plan); });
}

bool CycleNode::is_among(const std::vector<Eigen::Vector3d>& centroids_W,
                         const msgs::GraspPlan& plan) {
  const Eigen::Vector3d p_W = convert::from_message(plan.centroid());
  return std::any_of(
      centroids_W.begin(), centroids_W.end(),
      [&p_W](const Eigen::Vector3d& other_W) { return (p_W - other_W).norm() < kSameObject; });
}

// With a task of all objects: it is at its place, or was given up.
bool CycleNode::is_settled(const msgs::GraspPlan& plan) const {
  return is_placed(plan) || (task_.all_objects && is_among(given_up_W_, plan));
}

bool CycleNode::is_placed(const msgs::GraspPlan& plan) const {
  return task_.all_objects && task_.is_placed(convert::from_message(plan.centroid()).head<2>());
}

void CycleNode::start(const View& view) {
  robot_patience_.reset();
  given_up_W_.clear();  // by the cycle before
  failed_W_.clear();
  object_ = node_.parameter<int>("object");
  grasp_ = node_.parameter<int>("grasp");
  if (grasp_ >= 0 && object_ < 0) {
    throw std::invalid_argument(
        fmt::format("the parameter grasp is {}, of no object: set object, too", grasp_));
  }
  const Target target = target_in(view, object_);
  if (target.grasps.empty()) {
    if (!target.none_left && prepares_push(view, object_)) return begin(grasp::in_words(target));
    target_ = target.id;
    control::CycleResult nothing;
    if (target.none_left) nothing.outcome = CycleOutcome::kSucceeded;
    if (target.outcome == grasp::PlanOutcome::kUngraspable) {
      nothing.outcome = CycleOutcome::kUngraspable;
    }
    nothing.reason = target.problem;
    return finish(nothing);
  }
  take_target(view, target.id);
  const std::string destination =
      robot_->prepare(view, target, grasp_ < 0 ? std::nullopt : std::optional(grasp_));
  node_.log_info(
      "grasping object {}: {} grasps, {} {:.2f}; it is {}", target.id, target.grasps.size(),
      grasp_ < 0 ? "best score" : fmt::format("first that of rank {}, score", grasp_),
      target.grasps[static_cast<std::size_t>(std::max(grasp_, 0))]->score(), destination);
  if (!predicted_.wanted()) return begin();
  preparing_ = true;
  predicted_.put(view, target.id, task_.all_objects, [this](const std::string& problem) {
    preparing_ = false;
    if (!problem.empty()) return fail(problem);
    publish_state(control::Phase::kSpawn, 0,
                  fmt::format("object {} is in the simulation as it was predicted", target_));
    const std::string failure = node_.shield("plan", [this] { begin(); });
    if (!failure.empty()) fail(failure);
  });
}

void CycleNode::take_target(const View& view, std::uint32_t id) {
  target_ = id;
  target_plan_ = view.plans.at(id);
  const auto model = view.models.find(id);
  target_model_ = model == view.models.end() ? nullptr : model->second;
  centroid_W_ = convert::from_message(target_plan_->centroid());
  view_stamp_ = target_plan_->header().stamp();
}

bool CycleNode::prepares_push(const View& view, int object) {
  // Without a target predicted objects are not put into a simulation.
  if (!task_.does(control::Primitive::kPush) || predicted_.wanted()) return false;
  const msgs::GraspPlan* plan = choose_push(view, [this, object](const msgs::GraspPlan& one) {
    return object >= 0 ? one.id() != static_cast<std::uint32_t>(object) : is_placed(one);
  });
  if (!plan) return false;
  robot_->prepare_push(*plan);
  take_target(view, plan->id());
  node_.log_info("nothing can be grasped: object {} is to be pushed", target_);
  return true;
}

void CycleNode::begin(const std::string& problem) {
  surprises_sent_ = surprises_before_ = 0;
  evidence_sent_ = loads_sent_ = looks_sent_ = percepts_sent_ = placed_sent_ = 0;
  last_detail_.clear();
  robot_->start(problem);
  running_ = true;
}

void CycleNode::look_again(double since) {
  if (predicted_.wanted()) {
    if (const std::string problem = predicted_.look(since); !problem.empty()) {
      return robot_->take_nothing(problem);
    }
  } else {
    look_.ask(since);
    if (!look_.problem().empty()) return robot_->take_nothing(look_.problem());
  }
  const auto now = steady_clock::now();
  const View* view = views_.newest_ready(now, graph::nanoseconds(since));
  if (!view) {
    const std::string nothing = views_.why_nothing(now, graph::nanoseconds(since));
    if (!nothing.empty()) robot_->take_nothing(nothing);
    return;
  }
  const std::string failure = node_.shield("plan", [&] {
    const bool any = robot_->cycle().any_object();
    // What was given up comes last once something else was moved.
    const int given_up = robot_->cycle().given_up();
    if (static_cast<int>(given_up_W_.size()) > given_up) {
      failed_W_.insert(failed_W_.end(), given_up_W_.begin(), given_up_W_.end());
      given_up_W_.clear();
    }
    if (static_cast<int>(given_up_W_.size()) < given_up) given_up_W_.push_back(centroid_W_);
    // Ids are of one view: the object asked for is what lies nearest to where it was. A simulation
    // of predicted objects keeps them.
    int object = any || object_ < 0 ? -1 : nearest_object(*view, centroid_W_);
    if (predicted_.wanted() && !any) object = static_cast<int>(target_);
    // Of any object another one is tried first than what is not as it was predicted, and would
    // be predicted like that again. A task of all comes to these after it.
    const std::span surprises(robot_->cycle().surprises());
    const bool met = met_too_early(surprises.subspan(surprises_before_));
    surprises_before_ = surprises.size();
    if (met && object < 0 && !any && !task_.all_objects) {
      const int failed = nearest_object(*view, centroid_W_);
      failed_W_.push_back(
          convert::from_message(view->plans.at(static_cast<std::uint32_t>(failed))->centroid()));
    }
    const Target target = target_in(*view, object);
    if (target.grasps.empty()) {
      const std::string problem = grasp::in_words(target);
      if (any && !target.none_left && prepares_push(*view, -1))
        return robot_->take_prepared(problem);
      return robot_->take_nothing(problem);
    }
    const std::string destination = robot_->prepare(*view, target);
    take_target(*view, target.id);
    node_.log_info("seen again: grasping object {}, {} grasps; it is {}", target.id,
                   target.grasps.size(), destination);
    robot_->take_prepared();
  });
  if (!failure.empty()) robot_->take_nothing(failure);
}

void CycleNode::publish_evidence() {
  const control::AttemptWatch& watch = robot_->attempt_watch();
  const auto publish = [&](msgs::AttemptEvidence message) {
    message.mutable_header()->set_stamp(view_stamp_);
    message.set_object_id(target_);
    message.set_attempt(static_cast<std::uint32_t>(evidence_sent_));
    message.set_hand(robot_->hand_name());
    evidence_.publish(std::move(message));
  };
  if (watch.concluded() != evidence_sent_) {
    evidence_sent_ = watch.concluded();
    publish(convert::to_message(watch.attempt()));
  }
  if (const int looks = robot_->cycle().result().looks; looks != looks_sent_) {
    looks_sent_ = looks;
    msgs::AttemptEvidence message;
    message.set_looks(true);
    publish(std::move(message));
  }
  if (watch.load().concluded() != loads_sent_) {
    loads_sent_ = watch.load().concluded();
    msgs::AttemptEvidence message;
    *message.mutable_load() = convert::to_message(watch.load().found());
    publish(std::move(message));
  }
}

void CycleNode::publish_placed() {
  const control::CycleResult& result = robot_->cycle().result();
  if (result.placed == placed_sent_) return;
  placed_sent_ = result.placed;
  if (!target_model_ || !target_model_->valid()) return;
  const msgs::Grasp& grasp = target_plan_->grasps(result.grasp_index);
  if (!grasp.has_move()) return;
  geometry::RigidTransform X_moved = geometry::RigidTransform::Identity();
  X_moved.translation() = convert::from_message(grasp.move());
  placed_.publish(moved_model(*target_model_, X_moved));
}

void CycleNode::publish_percepts() {
  const control::PerceptWatch& watch = robot_->percept_watch();
  if (watch.concluded() == percepts_sent_) return;
  percepts_sent_ = watch.concluded();
  msgs::ActPercepts message;
  message.mutable_header()->set_stamp(view_stamp_);
  message.set_object_id(target_);
  message.set_grasp_index(static_cast<std::uint32_t>(watch.grasp_index()));
  message.set_attempt(static_cast<std::uint32_t>(watch.tries()));
  message.set_hand(robot_->hand_name());
  *message.mutable_percepts() = convert::to_message(watch.percepts());
  if (auto view = robot_->take_lift_view()) {
    *message.mutable_percepts()->mutable_view() = std::move(*view);
  }
  percepts_.publish(std::move(message));
}

void CycleNode::publish_progress() {
  const control::Cycle& cycle = robot_->cycle();
  for (; surprises_sent_ < cycle.surprises().size(); ++surprises_sent_) {
    const auto message =
        convert::to_message(cycle.surprises()[surprises_sent_], node_.clock().now());
    if (message.surprising()) {
      node_.log_warning("surprise: {} predicted {:.4g}, felt {:.4g}: {}",
                        msgs::Surprise::Kind_Name(message.kind()), message.predicted(),
                        message.felt(), message.reaction());
    }
    surprises_.publish(message);
  }
  if (cycle.detail() == last_detail_) return;  // every action's step has words of its own
  last_detail_ = cycle.detail();
  publish_state(cycle.phase(), cycle.grasp_index(), last_detail_);
}

void CycleNode::publish_state(control::Phase phase, int grasp_index, const std::string& detail) {
  msgs::CycleState state;
  state.mutable_header()->set_stamp(node_.clock().now());
  state.set_phase(convert::to_message(phase));
  state.set_object_id(target_);
  state.set_view_stamp(view_stamp_);
  state.set_grasp_index(static_cast<std::uint32_t>(grasp_index));
  state.set_detail(detail);
  if (running_ && !robot_->cycle().path().empty()) {
    state.set_task_state(task_.name_of(robot_->cycle().path().back()));
  }
  states_.publish(state);
  node_.log_info("{}: {}", control::to_string(phase), detail);
}

void CycleNode::fail(const std::string& reason) {
  control::CycleResult failure;
  failure.reason = reason;
  finish(failure);
}

void CycleNode::finish(const control::CycleResult& result) {
  const std::int64_t now = node_.clock().now();
  msgs::CycleResult message =
      running_ ? convert::to_message(robot_->cycle(), now) : convert::to_message(result, now);
  message.set_object_id(target_);
  results_.publish(message);
  running_ = preparing_ = false;
  switch (result.outcome) {
    case CycleOutcome::kSucceeded:
      node_.log_info("success: {}", result.reason);
      exit_code_ = 0;
      break;
    case CycleOutcome::kUngraspable:
      node_.log_info("{}", grasp::ungraspable_text(result.reason));
      exit_code_ = ungraspable_is_ok_ ? 0 : graph::kAnswerIsNo;
      break;
    case CycleOutcome::kFailed:
      node_.report(graph::Health::kError, result.reason);
      exit_code_ = 2;
      break;
  }
  if (exits_) exit_time_ = steady_clock::now() + kExitDelay;
}

}  // namespace prehend::nodes
