#include "drivers/pg70/node/gripper_offers.h"

#include <chrono>
#include <optional>
#include <string>
#include <thread>

#include "msgs/convert/gripper.h"

namespace prehend::drivers::pg70 {
namespace {

using Kind = MotionReport::Kind;

constexpr auto kTick = std::chrono::milliseconds(10);
constexpr int kTicksPerFeedback = 5;  // 20 Hz

msgs::Acknowledge answer(bool success, const std::string& reason = {}) {
  msgs::Acknowledge message;
  message.set_success(success);
  message.set_reason(reason);
  return message;
}

// What the module's protocol has.
std::optional<MotionMode> mode_of(robot::GripperMode mode) {
  switch (mode) {
    case robot::GripperMode::kStop:
      return MotionMode::kStop;
    case robot::GripperMode::kPosition:
      return MotionMode::kPosition;
    case robot::GripperMode::kVelocity:
      return MotionMode::kVelocity;
    case robot::GripperMode::kCurrent:
      return MotionMode::kCurrent;
    case robot::GripperMode::kVoltage:
      break;
  }
  return std::nullopt;
}

}  // namespace

msgs::GripperState state_message(const Reading& reading, std::int64_t stamp) {
  msgs::GripperState message;
  message.mutable_header()->set_stamp(stamp);
  message.mutable_header()->set_frame_id("gripper");
  message.set_opening(reading.opening);
  message.set_velocity(reading.velocity);
  message.set_current(reading.current);
  message.set_referenced(reading.referenced);
  message.set_moving(reading.moving);
  message.set_blocked(reading.blocked);
  message.set_error_code(reading.error_code);
  return message;
}

GripperOffers::GripperOffers(graph::Node& node, Device& device,
                             nodes::EmergencyStopListener& emergency)
    : node_(node), device_(device), emergency_(emergency) {
  stop_ = node.serve<msgs::Empty, msgs::Acknowledge>(
      "/gripper/stop", [this](const msgs::Empty&) { return stop(false); });
  fast_stop_ = node.serve<msgs::Empty, msgs::Acknowledge>(
      "/gripper/fast_stop", [this](const msgs::Empty&) { return stop(true); });
  acknowledge_ = node.serve<msgs::Empty, msgs::Acknowledge>(
      "/gripper/acknowledge", [this](const msgs::Empty&) { return acknowledge(); });
  reference_ =
      node.serve<msgs::Empty, msgs::Acknowledge>("/gripper/reference", [this](const msgs::Empty&) {
        const std::string refusal = device_.with_driver([this](Driver& driver, Time now) {
          const std::string stopped = emergency_.refusal();
          return stopped.empty() ? driver.reference(now) : stopped;
        });
        return answer(refusal.empty(), refusal.empty() ? "it moves" : refusal);
      });
  command_ = node.subscribe<msgs::GripperCommand>(
      "/gripper/command", graph::QoS::queue(20),
      [this](const graph::Received<msgs::GripperCommand>& message) { command(*message); });
  move_ =
      node.serve_action<msgs::MoveGripperGoal, msgs::MoveGripperFeedback, msgs::MoveGripperResult>(
          "/gripper/move", [this](const msgs::MoveGripperGoal& goal, Context& context) {
            return move(goal, context);
          });
  emergency_stop_ = emergency.on_stop([this](const std::string& why) {
    device_.with_driver([&](Driver& driver, Time now) { driver.stop(now, why); });
  });
}

void GripperOffers::command(const msgs::GripperCommand& command) {
  const std::int64_t stamp = command.header().stamp();
  if (stamp != 0 && stamp <= action_stamp_) return;  // meant to come before the goal
  const auto refuse = [this](const std::string& why) {
    node_.log_warning("/gripper/command refused: {}", why);
  };
  const auto asked = convert::from_message(command.mode());
  if (!asked) return refuse("unknown mode of a gripper command");
  const auto mode = mode_of(*asked);
  if (!mode) {
    return refuse(msgs::GripperCommand::Mode_Name(command.mode()) +
                  ": the PG70 has no such command. Send POSITION, VELOCITY or CURRENT");
  }
  const std::string refusal = device_.with_driver([&](Driver& driver, Time now) {
    const std::string stopped = emergency_.refusal();
    if (!stopped.empty() && *mode != MotionMode::kStop) return stopped;
    return driver.command(*mode, command.value(), command.current_limit(), now);
  });
  if (!refusal.empty()) refuse(refusal);
}

// Says that it stands only when states show it, which as a rule takes some hundredths of a second.
std::string GripperOffers::wait_until_stopped() {
  constexpr int kPatience = 150;  // ticks: longer than the way from CMD STOP to CMD FAST STOP
  for (int i = 0; i < kPatience; ++i) {
    const bool stops =
        device_.with_driver([](Driver& driver, Time) { return driver.is_stopping(); });
    const Reading reading = device_.reading();
    if (!stops && reading.state >= DriverState::kFault && !reading.moving) return {};
    if (reading.state == DriverState::kDisconnected) break;
    std::this_thread::sleep_for(kTick);
  }
  return std::string("the gripper was told to stop, but does not show that it stands: ") +
         to_string(device_.reading().state);
}

msgs::Acknowledge GripperOffers::stop(bool is_fast) {
  const nodes::EmergencyStopListener::Wait wait(emergency_);
  const bool can_send = device_.with_driver([is_fast](Driver& driver, Time now) {
    if (is_fast) {
      driver.fast_stop(now, "stopped by /gripper/fast_stop");
    } else {
      driver.stop(now, "stopped by /gripper/stop");
    }
    return driver.reading().state != DriverState::kDisconnected;
  });
  if (!can_send) return answer(false, "the gripper is not connected: nothing can be sent");
  const std::string problem = wait_until_stopped();
  if (!problem.empty()) return answer(false, problem);
  const Reading reading = device_.reading();
  const bool has_failed = reading.state == DriverState::kFault;
  return answer(true, fmt::format("stands at {:.1f} mm{}", 1e3 * reading.opening,
                                  has_failed ? ", motor off: call /gripper/acknowledge" : ""));
}

// Waits for the module's word, which comes within some milliseconds.
msgs::Acknowledge GripperOffers::acknowledge() {
  const nodes::EmergencyStopListener::Wait wait(emergency_);
  const std::uint8_t code = device_.reading().error_code;
  const std::string refusal =
      device_.with_driver([](Driver& driver, Time now) { return driver.acknowledge(now); });
  if (!refusal.empty()) return answer(false, refusal);
  if (code == 0) return answer(true, "no error was present");
  constexpr int kPatience = 30;
  for (int i = 0; i < kPatience; ++i) {
    std::this_thread::sleep_for(kTick);
    const Reading reading = device_.reading();
    if (reading.error_code != 0) continue;
    if (reading.warning_code == 0) return answer(true);
    return answer(true,
                  "acknowledged, but its cause persists: " + describe_code(reading.warning_code));
  }
  return answer(false, describe_code(code));
}

msgs::MoveGripperResult GripperOffers::move(const msgs::MoveGripperGoal& goal, Context& context) {
  msgs::MoveGripperResult result;
  std::uint64_t ticket = 0;
  action_stamp_ = goal.stamp();
  const std::string refusal = device_.with_driver([&](Driver& driver, Time now) {
    const std::string stopped = emergency_.refusal();
    if (!stopped.empty()) return stopped;
    return driver.move_to(goal.opening(), goal.speed(), goal.current_limit(), now, ticket);
  });
  if (!refusal.empty()) {
    result.set_reason(refusal);
    result.set_opening(device_.reading().opening);
    return result;
  }
  for (int tick = 0; node_.ok(); ++tick) {
    std::this_thread::sleep_for(kTick);
    const MotionReport report =
        device_.with_driver([&](Driver& driver, Time) { return driver.report(ticket); });
    if (report.kind == Kind::kReplaced) {
      result.set_reason("another command took the gripper over");
      break;
    }
    if (report.kind == Kind::kReached) {
      result.set_reached(true);
      break;
    }
    if (report.kind == Kind::kBlocked) {
      result.set_blocked(true);
      result.set_reason("blocked");
      break;
    }
    if (report.kind == Kind::kFailed) {
      result.set_reason(report.reason);
      break;
    }
    if (context.cancelled()) {
      if (!context.preempted()) {
        device_.with_driver([](Driver& driver, Time now) { driver.stop(now, "cancelled"); });
        const std::string problem = wait_until_stopped();
        if (!problem.empty()) node_.log_warning("/gripper/move was cancelled, but {}", problem);
      }
      result.set_reason("cancelled");
      break;
    }
    if (tick % kTicksPerFeedback != 0) continue;
    msgs::MoveGripperFeedback feedback;
    feedback.set_opening(device_.reading().opening);
    context.feedback(feedback);
  }
  result.set_opening(device_.reading().opening);
  return result;
}

}  // namespace prehend::drivers::pg70
