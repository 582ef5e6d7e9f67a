#include "nodes/arm_cycle/arm_cycle_node.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "msgs/convert/geometry.h"
#include "msgs/sensors.pb.h"
#include "nodes/arm_cycle/arm_grasps.h"
#include "prehend/geometry/errors.h"
#include "prehend/graph/node_program.h"

namespace prehend::nodes {
namespace {

using std::chrono::steady_clock;

constexpr double kPeriod = 0.02;  // s, of the control loop
constexpr std::size_t kMostViews = 4;
constexpr auto kExitDelay = std::chrono::milliseconds(500);  // for the last messages

control::ArmCycleOptions declare_options(graph::Node& node, double look_timeout) {
  control::ArmCycleOptions options;
  options.look_timeout = look_timeout;
  options.reacts = node.declare_parameter<bool>(
      {.name = "reacts",
       .default_value = options.reacts,
       .description = "stop the approach where the hand touches, and close there; false: open "
                      "loop",
       .read_only = true});
  options.contact_force = node.declare_parameter<double>(
      {.name = "contact_force",
       .default_value = options.contact_force,
       .unit = "N",
       .minimum = 0.1,
       .description = "at the wrist, that counts as contact on the approach",
       .read_only = true});
  options.overrun = node.declare_parameter<double>(
      {.name = "overrun",
       .default_value = options.overrun,
       .unit = "rad",
       .minimum = 0.0,
       .description = "how far fingers go on beyond where they were predicted to touch, within "
                      "their limits",
       .read_only = true});
  options.holding.resolution = node.declare_parameter<double>(
      {.name = "force_resolution",
       .default_value = options.holding.resolution,
       .unit = "N",
       .minimum = 0.001,
       .description = "of the wrist's sensor: a change of less, or within its noise, does not show "
                      "that something is held",
       .read_only = true});
  options.stale_time = node.declare_parameter<double>(
      {.name = "stale_time",
       .default_value = options.stale_time,
       .unit = "s",
       .minimum = 0.02,
       .maximum = 10,
       .description = "without a word of joints or wrist: all is stopped",
       .read_only = true});
  options.answer_time =
      node.declare_parameter<double>({.name = "answer_time",
                                      .default_value = options.answer_time,
                                      .unit = "s",
                                      .minimum = 0.1,
                                      .maximum = 60,
                                      .description = "without feedback of a motion: all is stopped",
                                      .read_only = true});
  options.largest_attempts =
      node.declare_parameter<int>({.name = "largest_attempts",
                                   .default_value = options.largest_attempts,
                                   .minimum = 1,
                                   .description = "grasps tried before giving up",
                                   .read_only = true});
  return options;
}

}  // namespace

ArmCycleNode::ArmCycleNode(graph::Node& node)
    : node_(node),
      object_(node.declare_parameter<int>({.name = "object",
                                           .default_value = -1,
                                           .minimum = -1,
                                           .description = "id of the object to grasp, -1: the one "
                                                          "with the best grasp",
                                           .read_only = true})),
      exits_(node.declare_parameter<bool>({.name = "exit_when_done",
                                           .default_value = false,
                                           .description = "end the process after the result",
                                           .read_only = true})),
      patience_(node.declare_parameter<double>(
          {.name = "patience",
           .default_value = 20.0,
           .unit = "s",
           .minimum = 0.0,
           .description = "wall time to wait for the next plan of a view",
           .read_only = true})),
      look_(node),
      options_(declare_options(node, look_.timeout())),
      arm_(node),
      hand_(node),
      cycle_(options_, arm_, hand_),
      surprises_(node.advertise<msgs::Surprise>("/surprise", graph::QoS::latched(32))),
      states_(node.advertise<msgs::CycleState>("/cycle/state", graph::QoS::latched(64))),
      results_(node.advertise<msgs::CycleResult>("/cycle/result", graph::QoS::latched(1))) {
  using graph::QoS;
  subscriptions_.push_back(node.subscribe<msgs::JointState>(
      "/joint_states", QoS::latest(), [this](const auto& message) { joints_ = message.shared(); }));
  subscriptions_.push_back(
      node.subscribe<msgs::Wrench>("/wrench", QoS::latest(), [this](const auto& message) {
        // What cannot be read leaves the older one in place, which soon is too old to move by.
        wrist_force_ = convert::from_message(message->wrench().force());
        wrist_stamp_ = message->header().stamp();
      }));
  subscriptions_.push_back(
      node.subscribe<msgs::GraspPlan>("/plans", QoS::latched(32), [this](const auto& plan) {
        View& view = views_[plan->header().stamp()];
        view.plans[plan->id()] = plan.shared();
        view.newest = steady_clock::now();
        if (views_.size() > kMostViews) views_.erase(views_.begin());
      }));
  start_service_ =
      node.serve<msgs::Empty, msgs::Acknowledge>("/cycle/start", [this](const msgs::Empty&) {
        msgs::Acknowledge answer;
        answer.set_success(!running_);
        answer.set_reason(running_ ? "a cycle is running" : "starts on the newest plans");
        armed_ = armed_ || !running_;
        return answer;
      });
  timer_ = node.create_timer(kPeriod, [this] { tick(); });
}

const ArmCycleNode::View* ArmCycleNode::newest_ready(std::int64_t since) const {
  if (views_.empty() || views_.rbegin()->first < since) return nullptr;
  const View& view = views_.rbegin()->second;
  const std::size_t objects = view.plans.begin()->second->object_count();
  const bool complete = view.plans.size() >= objects;
  return complete || steady_clock::now() - view.newest > patience_ ? &view : nullptr;
}

void ArmCycleNode::tick() {
  if (exit_time_ && steady_clock::now() >= *exit_time_) return node_.shutdown();
  control::ArmPercepts percepts;
  percepts.time = graph::seconds(node_.clock().now());
  if (joints_) {
    percepts.names.assign(joints_->name().begin(), joints_->name().end());
    percepts.positions.assign(joints_->position().begin(), joints_->position().end());
    percepts.joints_age = percepts.time - graph::seconds(joints_->header().stamp());
  }
  percepts.wrist_force = wrist_force_;
  percepts.wrist_age = percepts.time - graph::seconds(wrist_stamp_);
  if (running_) {
    // A step that cannot be done is no reason to let things move on.
    const std::string failure = node_.shield("cycle", [&] {
      cycle_.step(percepts);
      if (const auto since = cycle_.looks_since()) look_again(*since);
    });
    if (!failure.empty()) cycle_.abort("a step of the cycle failed: " + failure);
    publish_progress();
    if (cycle_.finished()) finish(cycle_.result(), false);
    return;
  }
  if (!armed_) return;
  if (const View* view = newest_ready(std::numeric_limits<std::int64_t>::min())) {
    armed_ = false;
    cycle_.step(percepts);  // it knows where the arm stands before it starts
    control::CycleResult failure;
    failure.reason = node_.shield("plan", [&] { start(*view); });
    if (!failure.reason.empty()) finish(failure, false);
  }
}

ArmCycleNode::Choice ArmCycleNode::choose(const View& view, int object) const {
  Choice choice;
  std::map<std::string, std::string> problems;  // of which objects
  for (const auto& [id, plan] : view.plans) {
    if (object >= 0 && id != static_cast<std::uint32_t>(object)) continue;
    choice.known = true;
    std::vector<control::ArmGrasp> own;
    std::string problem = plan->problem();
    const msgs::Grasp* best = nullptr;
    for (const msgs::Grasp& grasp : plan->grasps()) {
      choice.planned = true;
      if (!is_executable(grasp)) continue;
      try {
        own.push_back(from_message(grasp));
        if (!best) best = &grasp;
      } catch (const geometry::InputError& error) {
        problem = error.what();
        break;  // indices are those of the plan
      }
    }
    if (!best) {
      std::string& objects =
          problems[problem.empty() ? "no grasp with a way for the arm" : problem];
      objects += fmt::format("{}object {}", objects.empty() ? "" : ", ", id);
    }
    if (!best || (!choice.grasps.empty() && best->score() <= choice.grasps.front().score)) continue;
    choice.object = id;
    choice.destination = destination(*best);
    choice.grasps = std::move(own);
  }
  for (const auto& [problem, objects] : problems) {
    choice.problem += (choice.problem.empty() ? "" : "; ") + objects + ": " + problem;
  }
  if (!choice.known) choice.problem = fmt::format("there is no plan of object {}", object);
  return choice;
}

void ArmCycleNode::start(const View& view) {
  Choice choice = choose(view, object_);
  if (choice.grasps.empty()) {
    control::CycleResult failure;
    failure.reason = choice.problem;
    return finish(failure, choice.known && !choice.planned);
  }
  target_ = choice.object;
  centroid_W_ = convert::from_message(view.plans.at(target_)->centroid());
  node_.log_info("grasping object {}: {} grasps that the arm can execute, first {}; it is {}",
                 target_, choice.grasps.size(), control::described(choice.grasps.front(), 0),
                 choice.destination);
  surprises_sent_ = 0;
  last_detail_.clear();
  running_ = true;
  cycle_.start(std::move(choice.grasps));
  publish_progress();
}

void ArmCycleNode::look_again(double since) {
  look_.ask(since);
  if (!look_.problem().empty()) return cycle_.take_plan({}, look_.problem());
  const View* view = newest_ready(graph::nanoseconds(since));
  if (!view) return;
  Choice choice = choose(*view, object_ < 0 ? -1 : nearest_object(view->plans, centroid_W_));
  if (!choice.grasps.empty()) {
    target_ = choice.object;
    centroid_W_ = convert::from_message(view->plans.at(target_)->centroid());
  }
  cycle_.take_plan(std::move(choice.grasps), choice.problem);
}

msgs::Surprise ArmCycleNode::to_message(const control::Surprise& surprise) const {
  msgs::Surprise message;
  message.mutable_header()->set_stamp(node_.clock().now());
  message.set_kind(static_cast<msgs::Surprise::Kind>(surprise.kind));
  message.set_predicted(surprise.predicted);
  message.set_felt(surprise.felt);
  message.set_tolerance(surprise.tolerance);
  message.set_surprising(surprise.surprising);
  message.set_reaction(surprise.reaction);
  return message;
}

void ArmCycleNode::publish_progress() {
  for (; surprises_sent_ < cycle_.surprises().size(); ++surprises_sent_) {
    const msgs::Surprise message = to_message(cycle_.surprises()[surprises_sent_]);
    if (message.surprising()) {
      node_.log_warning("surprise: {} predicted {:.4g}, felt {:.4g}: {}",
                        msgs::Surprise::Kind_Name(message.kind()), message.predicted(),
                        message.felt(), message.reaction());
    }
    surprises_.publish(message);
  }
  if (cycle_.detail() == last_detail_) return;
  last_detail_ = cycle_.detail();
  msgs::CycleState state;
  state.mutable_header()->set_stamp(node_.clock().now());
  state.set_phase(control::to_string(cycle_.phase()));
  state.set_object_id(target_);
  state.set_grasp_index(static_cast<std::uint32_t>(cycle_.grasp_index()));
  state.set_detail(last_detail_);
  states_.publish(state);
  node_.log_info("{}: {}", state.phase(), state.detail());
}

void ArmCycleNode::finish(const control::CycleResult& result, bool ungraspable) {
  msgs::CycleResult message;
  message.mutable_header()->set_stamp(node_.clock().now());
  message.set_success(result.success);
  message.set_reason(result.reason);
  message.set_object_id(target_);
  message.set_grasp_index(static_cast<std::uint32_t>(result.grasp_index));
  message.set_attempts(static_cast<std::uint32_t>(result.attempts));
  if (running_) {
    for (const auto& surprise : cycle_.surprises()) *message.add_surprises() = to_message(surprise);
    for (const auto& [phase, seconds] : cycle_.phase_times()) {
      auto& time = *message.add_times();
      time.set_stage(phase);
      time.set_seconds(seconds);
    }
  }
  results_.publish(message);
  running_ = false;
  if (result.success) {
    node_.log_info("success: {}", result.reason);
  } else {
    node_.report(graph::Health::kError, result.reason);
  }
  exit_code_ = result.success ? 0 : (ungraspable ? graph::kAnswerIsNo : 2);
  if (exits_) exit_time_ = steady_clock::now() + kExitDelay;
}

}  // namespace prehend::nodes
