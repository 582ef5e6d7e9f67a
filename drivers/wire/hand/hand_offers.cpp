#include "drivers/wire/hand/hand_offers.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include <fmt/format.h>

#include "msgs/convert/gripper.h"

namespace prehend::drivers {
namespace {

constexpr auto kTick = std::chrono::milliseconds(10);
constexpr int kTicksPerFeedback = 5;  // 20 Hz
constexpr double kSlack = 1e-4;       // rad, beyond limits

[[noreturn]] void refuse_goal(const std::string& words) { throw std::invalid_argument(words); }

void refuse_beyond_limits(const HandAxes& axes, std::size_t axis, double position) {
  const double lower = axes.lower(axis), upper = axes.upper(axis);
  if (position >= lower - kSlack && position <= upper + kSlack) return;
  refuse_goal(fmt::format("'{}' at {:.4f} is outside {:.4f} to {:.4f}", axes.joints()[axis],
                          position, lower, upper));
}

msgs::Acknowledge answer(bool success, const std::string& reason = {}) {
  msgs::Acknowledge message;
  message.set_success(success);
  message.set_reason(reason);
  return message;
}

}  // namespace

HandOffers::HandOffers(graph::Node& node, OfferedHand& hand, const HandAxes& axes,
                       nodes::EmergencyStopListener& emergency, bool has_off)
    : node_(node), hand_(hand), axes_(axes), emergency_(emergency) {
  stop_ = node.serve<msgs::Empty, msgs::Acknowledge>(
      "/hand/stop", [this](const msgs::Empty&) { return stop(false); });
  if (has_off) {
    off_ = node.serve<msgs::Empty, msgs::Acknowledge>(
        "/hand/off", [this](const msgs::Empty&) { return stop(true); });
  }
  command_ = node.subscribe<msgs::JointCommand>(
      "/hand/command", graph::QoS::queue(20),
      [this](const graph::Received<msgs::JointCommand>& message) { command(*message); });
  move_ = node.serve_action<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult>(
      "/hand/move",
      [this](const msgs::MoveHandGoal& goal, Context& context) { return move(goal, context); });
  emergency_stop_ = emergency.on_stop([this](const std::string& why) { hand_.stop(why); });
}

std::vector<std::size_t> HandOffers::named(
    const google::protobuf::RepeatedPtrField<std::string>& joints) const {
  std::vector<std::size_t> axes;
  for (const std::string& name : joints) {
    const auto axis = axes_.axis_named(name);
    if (!axis) refuse_goal(fmt::format("the hand has no motor '{}'{}", name, axes_.hint(name)));
    if (std::ranges::find(axes, *axis) != axes.end()) {
      refuse_goal(fmt::format("joint '{}' is named twice", name));
    }
    axes.push_back(*axis);
  }
  return axes;
}

std::vector<OfferedHand::Target> HandOffers::check(const msgs::MoveHandGoal& goal) const {
  const int count = goal.joint_name_size();
  if (count == 0) refuse_goal("the goal names no joint");
  if (goal.position_size() != count) {
    refuse_goal(fmt::format("{} positions for {} joints", goal.position_size(), count));
  }
  if (goal.effort_size() != 0 && goal.effort_size() != count) {
    refuse_goal(fmt::format("{} efforts for {} joints", goal.effort_size(), count));
  }
  if (!(goal.speed() > 0 && goal.speed() <= 1)) refuse_goal("speed must be in (0, 1]");
  std::vector<OfferedHand::Target> targets;
  const std::vector<std::size_t> axes = named(goal.joint_name());
  for (int i = 0; i < count; ++i) {
    const std::size_t axis = axes[static_cast<std::size_t>(i)];
    const std::string& name = axes_.joints()[axis];
    const double target = goal.position(i);
    if (!std::isfinite(target)) refuse_goal("the position of '" + name + "' is not finite");
    refuse_beyond_limits(axes_, axis, target);
    double current = 0;  // the greatest
    if (goal.effort_size() > 0) {
      const double most = axes_.most_effort(axis);
      if (!(goal.effort(i) > 0 && goal.effort(i) <= most * (1 + 1e-9))) {
        refuse_goal(fmt::format("the effort of '{}' must be in (0, {:.3f}], not {}", name, most,
                                goal.effort(i)));
      }
      current = axes_.current_of(axis, goal.effort(i));
    }
    targets.push_back({axis, target, goal.speed() * axes_.max_speed(axis), current});
  }
  return targets;
}

msgs::MoveHandResult HandOffers::move(const msgs::MoveHandGoal& goal, Context& context) {
  msgs::MoveHandResult result;
  std::vector<std::size_t> axes;
  const auto finish = [&](const std::string& reason) {
    const std::vector<double> positions = hand_.positions();
    for (const std::size_t axis : axes) result.add_position(positions[axis]);
    result.set_reason(reason);
    return result;
  };
  std::uint64_t ticket = 0;
  try {
    const std::vector<OfferedHand::Target> targets = check(goal);
    for (const OfferedHand::Target& target : targets) axes.push_back(target.axis);
    action_stamp_ = goal.stamp();
    is_switched_off_ = false;
    const std::string refusal = hand_.move_to(targets, ticket);
    if (!refusal.empty()) return finish(refusal);
  } catch (const std::invalid_argument& error) {
    return finish(error.what());
  }
  for (int tick = 0; node_.ok(); ++tick) {
    std::this_thread::sleep_for(kTick);
    const MotionReport report = hand_.report(ticket);
    switch (report.kind) {
      case MotionReport::Kind::kRunning:
        break;
      case MotionReport::Kind::kReplaced:
        return finish("another command took the hand over");
      case MotionReport::Kind::kReached:
        result.set_reached(true);
        return finish("");
      case MotionReport::Kind::kBlocked:
        result.set_blocked(true);
        return finish(goal.until_contact() ? "pressing" : "blocked");
      case MotionReport::Kind::kFailed:
        return finish(report.reason);
    }
    if (context.cancelled()) {
      if (!context.preempted()) {
        hand_.stop("cancelled");
        const std::string problem = wait_until_stopped();
        if (!problem.empty()) node_.log_warning("/hand/move was cancelled, but {}", problem);
      }
      return finish("cancelled");
    }
    if (tick % kTicksPerFeedback != 0) continue;
    msgs::MoveHandFeedback feedback;
    for (const double position : hand_.positions()) feedback.add_position(position);
    context.feedback(feedback);
  }
  return finish("the driver ends");
}

std::string HandOffers::take(const msgs::JointCommand& command) {
  const std::int64_t stamp = command.header().stamp();
  if (stamp != 0 && stamp <= action_stamp_) {
    return "ignored: it is stamped before the goal of /hand/move that came";
  }
  const auto mode = convert::from_message(command.mode());
  if (!mode) return "refused: unknown mode of a joint command";
  if (*mode == robot::JointMode::kEffort || *mode == robot::JointMode::kVoltage) {
    return fmt::format(
        "refused: {}: the {} has no such command. Send POSITION or VELOCITY; efforts of "
        "/hand/move limit its currents",
        msgs::JointCommand::Mode_Name(command.mode()), axes_.device());
  }
  const bool stops = *mode == robot::JointMode::kStop;
  try {
    if (!stops && command.joint_name_size() == 0) refuse_goal("the command names no joint");
    if (stops && command.value_size() > 0) refuse_goal("values for joints that are to stop");
    if (!stops && command.value_size() != command.joint_name_size()) {
      refuse_goal(
          fmt::format("{} values for {} joints", command.value_size(), command.joint_name_size()));
    }
    std::vector<std::size_t> axes = named(command.joint_name());
    if (axes.empty()) {
      for (std::size_t i = 0; i < axes_.size(); ++i) axes.push_back(i);
    }
    std::vector<double> values(axes.size(), 0.0);
    for (std::size_t i = 0; i < axes.size() && !stops; ++i) {
      values[i] = command.value(static_cast<int>(i));
      if (!std::isfinite(values[i])) {
        refuse_goal("the value for '" + axes_.joints()[axes[i]] + "' is not finite");
      }
      if (*mode == robot::JointMode::kPosition) refuse_beyond_limits(axes_, axes[i], values[i]);
    }
    const CommandMode asked = stops                                  ? CommandMode::kStop
                              : *mode == robot::JointMode::kPosition ? CommandMode::kPosition
                                                                     : CommandMode::kVelocity;
    if (!stops) is_switched_off_ = false;
    const std::string refusal = hand_.command(asked, axes, values);
    return refusal.empty() ? "" : "refused: " + refusal;
  } catch (const std::invalid_argument& error) {
    return "refused: " + std::string(error.what());
  }
}

// A stream goes on: what is wrong with it is said when it begins.
void HandOffers::command(const msgs::JointCommand& command) {
  const std::string words = take(command);
  if (!words.empty() && words != said_) node_.log_warning("/hand/command {}", words);
  said_ = words;
}

// Says that it stands only when states show it.
std::string HandOffers::wait_until_stopped() {
  constexpr int kPatience = 250;  // ticks: longer than the way from stop to power off
  for (int i = 0; i < kPatience; ++i) {
    if (hand_.is_settled()) return {};
    if (!hand_.is_connected()) break;
    std::this_thread::sleep_for(kTick);
  }
  return std::string("the hand was told to stop, but does not show that it stands: ") +
         hand_.state();
}

msgs::Acknowledge HandOffers::stop(bool is_off) {
  const nodes::EmergencyStopListener::Wait wait(emergency_);
  is_switched_off_ = is_off;
  if (is_off) {
    hand_.power_off("switched off by /hand/off");
  } else {
    hand_.stop("stopped by /hand/stop");
  }
  if (!hand_.is_connected()) return answer(false, "the hand is not connected: nothing can be sent");
  const std::string problem = wait_until_stopped();
  if (!problem.empty()) return answer(false, problem);
  return answer(true, is_off ? "its axes are off; a motion switches them on" : "it stands");
}

}  // namespace prehend::drivers
