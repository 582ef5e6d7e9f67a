#include "nodes/grasp_cycle/ports.h"

#include <chrono>

#include "msgs/convert/geometry.h"

namespace prehend::nodes {

using control::MotionStatus;

GripperActions::GripperActions(graph::Node& node)
    : node_(node),
      commands_(node.advertise<msgs::GripperCommand>("/gripper/command", graph::QoS::queue(10))),
      client_(node.action_client<msgs::MoveGripperGoal, msgs::MoveGripperFeedback,
                                 msgs::MoveGripperResult>("/gripper/move")) {}

void GripperActions::move_to(double opening, double speed) {
  msgs::MoveGripperGoal goal;
  goal.set_opening(opening);
  goal.set_speed(speed);
  goal.set_stamp(node_.clock().now());
  goal_ = client_.send(goal);
}

MotionStatus GripperActions::motion() {
  if (!goal_ || !goal_.done()) return MotionStatus::kMoving;
  const auto outcome = goal_.wait(std::chrono::nanoseconds(0));
  if (!outcome.ok()) {
    node_.log_warning("/gripper/move: {}", outcome.error());
    return MotionStatus::kFailed;
  }
  if (outcome->reached()) return MotionStatus::kReached;
  node_.log_warning("/gripper/move: {}", outcome->reason());
  return outcome->blocked() ? MotionStatus::kContact : MotionStatus::kFailed;
}

void GripperActions::publish(msgs::GripperCommand::Mode mode, double value, double current_limit) {
  msgs::GripperCommand command;
  command.mutable_header()->set_stamp(node_.clock().now());
  command.set_mode(mode);
  command.set_value(value);
  command.set_current_limit(current_limit);
  commands_.publish(command);
}

void GripperActions::command_velocity(double speed, double current_limit) {
  publish(msgs::GripperCommand::VELOCITY, speed, current_limit);
}

void GripperActions::stop() {
  if (goal_ && !goal_.done()) goal_.cancel();
  publish(msgs::GripperCommand::STOP, 0, 0);
}

CarrierActions::CarrierActions(graph::Node& node)
    : node_(node),
      client_(node.action_client<msgs::MoveCarrierGoal, msgs::MoveCarrierFeedback,
                                 msgs::MoveCarrierResult>("/carrier/move")) {}

void CarrierActions::move_to(const geometry::RigidTransform& X_WG, double speed,
                             double contact_force) {
  msgs::MoveCarrierGoal goal;
  *goal.mutable_x_wg() = convert::to_message(X_WG);
  goal.set_speed(speed);
  goal.set_stop_on_contact(contact_force > 0);
  goal.set_contact_force(contact_force);
  goal_ = client_.send(goal);
}

MotionStatus CarrierActions::motion() {
  if (!goal_ || !goal_.done()) return MotionStatus::kMoving;
  const auto outcome = goal_.wait(std::chrono::nanoseconds(0));
  if (!outcome.ok()) {
    node_.log_warning("/carrier/move: {}", outcome.error());
    return MotionStatus::kFailed;
  }
  if (outcome->contact()) return MotionStatus::kContact;
  if (outcome->reached()) return MotionStatus::kReached;
  node_.log_warning("/carrier/move: {}", outcome->reason());
  return MotionStatus::kFailed;
}

void CarrierActions::stop() {
  if (goal_ && !goal_.done()) goal_.cancel();
}

}  // namespace prehend::nodes
