#pragma once

#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/emergency_stop_listener/emergency_stop_listener.h"
#include "nodes/simulation/simulated_robot.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// What moves the simulated gripper: action /gripper/move, topic /gripper/command, services
/// /gripper/stop, /gripper/fast_stop and /gripper/acknowledge. An emergency stop brakes the jaws
/// and holds them where they are: what they grip stays gripped.
class MotionActions {
 public:
  MotionActions(graph::Node& node, SimulatedRobot& robot, EmergencyStopListener& emergency);

 private:
  using GripperContext = graph::ActionContext<msgs::MoveGripperFeedback>;
  msgs::MoveGripperResult move_gripper(const msgs::MoveGripperGoal& goal, GripperContext& context);
  void command(const msgs::GripperCommand& command);

  graph::Node& node_;
  SimulatedRobot& robot_;
  const EmergencyStopListener& emergency_;
  graph::Service stop_, fast_stop_, acknowledge_;
  graph::Subscription command_;
  graph::ActionServer gripper_;
  EmergencyStopListener::Action emergency_stop_;
};

}  // namespace prehend::nodes
