#include "drivers/sdh/node/hand_offers.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "msgs/convert/gripper.h"

namespace prehend::drivers::sdh {
namespace {

using Kind = MotionReport::Kind;

constexpr auto kTick = std::chrono::milliseconds(10);
constexpr int kTicksPerFeedback = 5;  // 20 Hz
constexpr double kSlack = 1e-4;       // rad, beyond limits

[[noreturn]] void refuse_goal(const std::string& words) { throw std::invalid_argument(words); }

msgs::Acknowledge answer(bool success, const std::string& reason = {}) {
  msgs::Acknowledge message;
  message.set_success(success);
  message.set_reason(reason);
  return message;
}

}  // namespace

HandOffers::HandOffers(graph::Node& node, Device& device, const HandAxes& axes)
    : node_(node), device_(device), axes_(axes) {
  stop_ = node.serve<msgs::Empty, msgs::Acknowledge>(
      "/hand/stop", [this](const msgs::Empty&) { return stop(false); });
  off_ = node.serve<msgs::Empty, msgs::Acknowledge>(
      "/hand/off", [this](const msgs::Empty&) { return stop(true); });
  command_ = node.subscribe<msgs::JointCommand>(
      "/hand/command", graph::QoS::queue(20),
      [this](const graph::Received<msgs::JointCommand>& message) { command(*message); });
  move_ = node.serve_action<msgs::MoveHandGoal, msgs::MoveHandFeedback, msgs::MoveHandResult>(
      "/hand/move",
      [this](const msgs::MoveHandGoal& goal, Context& context) { return move(goal, context); });
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

HandOffers::Named HandOffers::check(const msgs::MoveHandGoal& goal) const {
  const int count = goal.joint_name_size();
  if (count == 0) refuse_goal("the goal names no joint");
  if (goal.position_size() != count) {
    refuse_goal(fmt::format("{} positions for {} joints", goal.position_size(), count));
  }
  if (goal.effort_size() != 0 && goal.effort_size() != count) {
    refuse_goal(fmt::format("{} efforts for {} joints", goal.effort_size(), count));
  }
  if (!(goal.speed() > 0 && goal.speed() <= 1)) refuse_goal("speed must be in (0, 1]");
  Named result;
  result.axes = named(goal.joint_name());
  const Limits& limits = axes_.limits();
  for (int i = 0; i < count; ++i) {
    const std::size_t axis = result.axes[static_cast<std::size_t>(i)];
    const std::string& name = axes_.joints()[axis];
    const double target = goal.position(i);
    if (!std::isfinite(target)) refuse_goal("the position of '" + name + "' is not finite");
    if (target < limits.lower[axis] - kSlack || target > limits.upper[axis] + kSlack) {
      refuse_goal(fmt::format("'{}' at {:.4f} is outside {:.4f} to {:.4f}", name, target,
                              limits.lower[axis], limits.upper[axis]));
    }
    double current = 0;  // the greatest
    if (goal.effort_size() > 0) {
      const double most = axes_.most_effort(axis);
      if (!(goal.effort(i) > 0 && goal.effort(i) <= most * (1 + 1e-9))) {
        refuse_goal(fmt::format("the effort of '{}' must be in (0, {:.3f}], not {}", name, most,
                                goal.effort(i)));
      }
      current = axes_.current_of(axis, goal.effort(i));
    }
    result.goal.moves[axis] = true;
    result.goal.position[axis] = target;
    result.goal.speed[axis] = goal.speed() * limits.max_speed[axis];
    result.goal.current[axis] = current;
  }
  return result;
}

msgs::MoveHandResult HandOffers::move(const msgs::MoveHandGoal& goal, Context& context) {
  msgs::MoveHandResult result;
  std::vector<std::size_t> axes;
  const auto finish = [&](const std::string& reason) {
    const Reading reading = device_.reading();
    for (const std::size_t axis : axes) result.add_position(reading.position[axis]);
    result.set_reason(reason);
    return result;
  };
  std::uint64_t ticket = 0;
  try {
    const Named named = check(goal);
    axes = named.axes;
    action_stamp_ = goal.stamp();
    const std::string refusal = device_.with_driver(
        [&](Driver& driver, Time now) { return driver.move_to(named.goal, now, ticket); });
    if (!refusal.empty()) return finish(refusal);
  } catch (const std::invalid_argument& error) {
    return finish(error.what());
  }
  for (int tick = 0; node_.ok(); ++tick) {
    std::this_thread::sleep_for(kTick);
    const MotionReport report =
        device_.with_driver([&](Driver& driver, Time) { return driver.report(ticket); });
    switch (report.kind) {
      case Kind::kRunning:
        break;
      case Kind::kReplaced:
        return finish("another command took the hand over");
      case Kind::kReached:
        result.set_reached(true);
        return finish("");
      case Kind::kBlocked:
        result.set_blocked(true);
        return finish(goal.until_contact() ? "pressing" : "blocked");
      case Kind::kFailed:
        return finish(report.reason);
    }
    if (context.cancelled()) {
      if (!context.preempted()) {
        device_.with_driver([](Driver& driver, Time now) { driver.stop(now, "cancelled"); });
        const std::string problem = wait_until_stopped();
        if (!problem.empty()) node_.log_warning("/hand/move was cancelled, but {}", problem);
      }
      return finish("cancelled");
    }
    if (tick % kTicksPerFeedback != 0) continue;
    msgs::MoveHandFeedback feedback;
    for (const double position : device_.reading().position) feedback.add_position(position);
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
        "refused: {}: the SDH-2 has no such command. Send POSITION or VELOCITY; efforts of "
        "/hand/move limit its currents",
        msgs::JointCommand::Mode_Name(command.mode()));
  }
  const bool stops = *mode == robot::JointMode::kStop;
  try {
    if (!stops && command.joint_name_size() == 0) refuse_goal("the command names no joint");
    if (stops && command.value_size() > 0) refuse_goal("values for joints that are to stop");
    if (!stops && command.value_size() != command.joint_name_size()) {
      refuse_goal(
          fmt::format("{} values for {} joints", command.value_size(), command.joint_name_size()));
    }
    std::array<bool, kAxes> moves{};
    AxisValues values{};
    const std::vector<std::size_t> axes = named(command.joint_name());
    if (axes.empty()) moves.fill(true);
    for (std::size_t i = 0; i < axes.size(); ++i) {
      const std::size_t axis = axes[i];
      moves[axis] = true;
      if (stops) continue;
      values[axis] = command.value(static_cast<int>(i));
      const std::string& name = axes_.joints()[axis];
      if (!std::isfinite(values[axis])) refuse_goal("the value for '" + name + "' is not finite");
      const Limits& limits = axes_.limits();
      if (*mode == robot::JointMode::kPosition && (values[axis] < limits.lower[axis] - kSlack ||
                                                   values[axis] > limits.upper[axis] + kSlack)) {
        refuse_goal(fmt::format("'{}' at {:.4f} is outside {:.4f} to {:.4f}", name, values[axis],
                                limits.lower[axis], limits.upper[axis]));
      }
    }
    const CommandMode asked = stops                                  ? CommandMode::kStop
                              : *mode == robot::JointMode::kPosition ? CommandMode::kPosition
                                                                     : CommandMode::kVelocity;
    const std::string refusal = device_.with_driver(
        [&](Driver& driver, Time now) { return driver.command(asked, moves, values, now); });
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
    const bool is_settled =
        device_.with_driver([](Driver& driver, Time) { return driver.is_settled(); });
    const DriverState state = device_.reading().state;
    if (is_settled && state >= DriverState::kFault) return {};
    if (state == DriverState::kDisconnected) break;
    std::this_thread::sleep_for(kTick);
  }
  return std::string("the hand was told to stop, but does not show that it stands: ") +
         to_string(device_.reading().state);
}

msgs::Acknowledge HandOffers::stop(bool is_off) {
  const bool can_send = device_.with_driver([is_off](Driver& driver, Time now) {
    if (is_off) {
      driver.power_off(now, "switched off by /hand/off");
    } else {
      driver.stop(now, "stopped by /hand/stop");
    }
    return driver.reading().state != DriverState::kDisconnected;
  });
  if (!can_send) return answer(false, "the hand is not connected: nothing can be sent");
  const std::string problem = wait_until_stopped();
  if (!problem.empty()) return answer(false, problem);
  return answer(true, is_off ? "its axes are off; a motion switches them on" : "it stands");
}

}  // namespace prehend::drivers::sdh
