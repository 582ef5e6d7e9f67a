#include "nodes/simulation/motion_actions.h"

#include <cmath>
#include <stdexcept>

#include "msgs/convert/geometry.h"
#include "msgs/convert/gripper.h"
#include "prehend/geometry/errors.h"

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

MotionActions::MotionActions(graph::Node& node, SimulatedRobot& robot)
    : node_(node), robot_(robot) {
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
  carrier_ =
      node.serve_action<msgs::MoveCarrierGoal, msgs::MoveCarrierFeedback, msgs::MoveCarrierResult>(
          "/carrier/move", [this](const msgs::MoveCarrierGoal& goal, CarrierContext& context) {
            return move_carrier(goal, context);
          });
  gripper_ =
      node.serve_action<msgs::MoveGripperGoal, msgs::MoveGripperFeedback, msgs::MoveGripperResult>(
          "/gripper/move", [this](const msgs::MoveGripperGoal& goal, GripperContext& context) {
            return move_gripper(goal, context);
          });
}

void MotionActions::command(const msgs::GripperCommand& command) {
  try {
    const auto mode = convert::from_message(command.mode());
    if (!mode) throw std::invalid_argument("unknown mode of a gripper command");
    robot_.command_gripper(*mode, command.value(), command.current_limit(),
                           command.header().stamp());
  } catch (const std::invalid_argument& error) {
    node_.log_warning("/gripper/command refused: {}", error.what());
  }
}

msgs::MoveCarrierResult MotionActions::move_carrier(const msgs::MoveCarrierGoal& goal,
                                                    CarrierContext& context) {
  msgs::MoveCarrierResult result;
  const auto reading = [this] {
    return robot_.with_world([](simulation::World& world) { return world.carrier(); });
  };
  try {
    if (goal.stop_on_contact() && !(goal.contact_force() > 0)) {
      throw std::invalid_argument("contact_force must be positive");
    }
    robot_.move_carrier(convert::from_message(goal.x_wg()), goal.speed(),
                        goal.stop_on_contact() ? goal.contact_force() : 0.0);
  } catch (const std::invalid_argument& error) {
    result.set_reason(error.what());
  } catch (const geometry::InputError& error) {
    result.set_reason(error.what());
  }
  if (!result.reason().empty()) {
    *result.mutable_x_wg() = convert::to_message(reading().X_WG);
    return result;
  }

  simulation::CarrierReading carrier = reading();
  bool cancelled = false;
  for (int slice = 0; carrier.moving && node_.ok(); ++slice) {
    if (context.preempted()) break;  // the newer goal brakes by itself
    if (context.cancelled() && !cancelled) {
      cancelled = true;
      robot_.stop_carrier();
    }
    robot_.wait_for_slice();
    carrier = reading();
    if (cancelled || slice % kSlicesPerFeedback != 0) continue;
    msgs::MoveCarrierFeedback feedback;
    *feedback.mutable_x_wg() = convert::to_message(carrier.X_WG);
    feedback.set_remaining(carrier.remaining);
    context.feedback(feedback);
  }
  result.set_contact(robot_.stopped_by_contact());
  result.set_reached(!carrier.moving && !cancelled && !result.contact());
  if (result.contact())
    result.set_reason("stopped by contact");
  else if (!result.reached())
    result.set_reason("stopped before the goal");
  *result.mutable_x_wg() = convert::to_message(carrier.X_WG);
  return result;
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
    ticket = robot_.move_gripper(goal.opening(), goal.speed(), goal.current_limit(), goal.stamp());
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
