#pragma once

#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/simulation/simulated_robot.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// What moves the simulated gripper: action /gripper/move, topic /gripper/command, services
/// /gripper/stop, /gripper/fast_stop and /gripper/acknowledge.
class MotionActions {
 public:
  MotionActions(graph::Node& node, SimulatedRobot& robot);

 private:
  using GripperContext = graph::ActionContext<msgs::MoveGripperFeedback>;
  msgs::MoveGripperResult move_gripper(const msgs::MoveGripperGoal& goal, GripperContext& context);
  void command(const msgs::GripperCommand& command);

  graph::Node& node_;
  SimulatedRobot& robot_;
  graph::Service stop_, fast_stop_, acknowledge_;
  graph::Subscription command_;
  graph::ActionServer gripper_;
};

}  // namespace prehend::nodes
