#include "nodes/simulation/motion_actions.h"

#include <cmath>
#include <stdexcept>

#include "msgs/convert/gripper.h"

namespace prehend::nodes {
namespace {

constexpr double kOpeningTolerance = 3e-4;  // m
constexpr int kSlicesPerFeedback = 5;       // 20 Hz

msgs::Acknowledge acknowledged(const char* words) {
  msgs::Acknowledge answer;
  answer.set_success(true);
  answer.set_reason(words);
  return answer;
}

}  // namespace

MotionActions::MotionActions(graph::Node& node, SimulatedRobot& robot,
                             EmergencyStopListener& emergency)
    : node_(node), robot_(robot), emergency_(emergency) {
  stop_ = node.serve<msgs::Empty, msgs::Acknowledge>("/gripper/stop", [this](const msgs::Empty&) {
    robot_.stop_gripper("stopped by /gripper/stop");
    return acknowledged("it brakes");
  });
  fast_stop_ =
      node.serve<msgs::Empty, msgs::Acknowledge>("/gripper/fast_stop", [this](const msgs::Empty&) {
        robot_.fast_stop_gripper("stopped by /gripper/fast_stop");
        return acknowledged("it brakes; call /gripper/acknowledge before it is to move again");
      });
  acknowledge_ = node.serve<msgs::Empty, msgs::Acknowledge>(
      "/gripper/acknowledge", [this](const msgs::Empty&) {
        return acknowledged(robot_.acknowledge_gripper() ? "" : "no error was present");
      });
  command_ = node.subscribe<msgs::GripperCommand>(
      "/gripper/command", graph::QoS::queue(20),
      [this](const graph::Received<msgs::GripperCommand>& message) { command(*message); });
  gripper_ =
      node.serve_action<msgs::MoveGripperGoal, msgs::MoveGripperFeedback, msgs::MoveGripperResult>(
          "/gripper/move", [this](const msgs::MoveGripperGoal& goal, GripperContext& context) {
            return move_gripper(goal, context);
          });
  emergency_stop_ = emergency.on_stop([this](const std::string& why) { robot_.stop_gripper(why); });
}

void MotionActions::command(const msgs::GripperCommand& command) {
  try {
    const auto mode = convert::from_message(command.mode());
    if (!mode) throw std::invalid_argument("unknown mode of a gripper command");
    const std::string why = emergency_.refusal();
    if (!why.empty() && *mode != robot::GripperMode::kStop) throw std::invalid_argument(why);
    robot_.command_gripper(*mode, command.value(), command.current_limit(),
                           command.header().stamp());
    // It came meanwhile.
    if (const std::string now = emergency_.refusal(); !now.empty()) robot_.stop_gripper(now);
  } catch (const std::invalid_argument& error) {
    node_.log_warning("/gripper/command refused: {}", error.what());
  }
}

msgs::MoveGripperResult MotionActions::move_gripper(const msgs::MoveGripperGoal& goal,
                                                    GripperContext& context) {
  msgs::MoveGripperResult result;
  const auto reading = [this] {
    return robot_.with_world([](simulation::World& world) { return world.gripper(); });
  };
  simulation::GripperReading gripper = reading();
  std::uint64_t ticket = 0;
  try {
    if (!(goal.speed() > 0)) throw std::invalid_argument("speed must be positive");
    if (const std::string why = emergency_.refusal(); !why.empty()) {
      throw std::invalid_argument(why);
    }
    ticket = robot_.move_gripper(goal.opening(), goal.speed(), goal.current_limit(), goal.stamp());
    // It came meanwhile.
    if (const std::string why = emergency_.refusal(); !why.empty()) robot_.stop_gripper(why);
  } catch (const std::invalid_argument& error) {
    result.set_reason(error.what());
    result.set_opening(gripper.opening);
    return result;
  }
  const auto there = [&] {
    return std::abs(gripper.opening - goal.opening()) < kOpeningTolerance && !gripper.moving;
  };
  for (int slice = 0; node_.ok(); ++slice) {
    robot_.wait_for_slice();
    gripper = reading();
    if (const std::string loss = robot_.loss_of_gripper(ticket); !loss.empty()) {
      result.set_reason(loss);
      break;
    }
    if (there()) {
      result.set_reached(true);
      break;
    }
    if (gripper.blocked) {
      result.set_blocked(true);
      result.set_reason("blocked");
      break;
    }
    if (context.cancelled()) {
      if (!context.preempted()) robot_.stop_gripper("cancelled");
      result.set_reason("cancelled");
      break;
    }
    if (slice % kSlicesPerFeedback != 0) continue;
    msgs::MoveGripperFeedback feedback;
    feedback.set_opening(gripper.opening);
    context.feedback(feedback);
  }
  result.set_opening(gripper.opening);
  return result;
}

}  // namespace prehend::nodes
