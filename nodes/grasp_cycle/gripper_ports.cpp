#include "nodes/grasp_cycle/gripper_ports.h"

namespace prehend::nodes {

using control::MotionStatus;

GripperActions::GripperActions(graph::Node& node)
    : node_(node),
      commands_(node.advertise<msgs::GripperCommand>("/gripper/command", graph::QoS::queue(10))),
      goal_(node, "/gripper/move") {}

void GripperActions::move_to(double opening, double speed) {
  msgs::MoveGripperGoal goal;
  goal.set_opening(opening);
  goal.set_speed(speed);
  goal.set_stamp(node_.clock().now());
  goal_.send(goal);
}

MotionStatus GripperActions::motion() {
  const auto outcome = goal_.end();
  if (!outcome) return MotionStatus::kMoving;
  if (!outcome->ok()) {
    node_.log_warning("/gripper/move: {}", outcome->error());
    return MotionStatus::kFailed;
  }
  const msgs::MoveGripperResult& result = **outcome;
  if (result.reached()) return MotionStatus::kReached;
  node_.log_warning("/gripper/move: {}", result.reason());
  return result.blocked() ? MotionStatus::kContact : MotionStatus::kFailed;
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
  goal_.stop();
  publish(msgs::GripperCommand::STOP, 0, 0);
}

}  // namespace prehend::nodes
