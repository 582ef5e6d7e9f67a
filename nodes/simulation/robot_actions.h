#pragma once

#include "msgs/actions.pb.h"
#include "nodes/arm_action/arm_action.h"
#include "nodes/emergency_stop_listener/emergency_stop_listener.h"
#include "nodes/simulation/robot_runner.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// What moves the simulated arm and hand: ArmAction, the action /hand/move, the topic /hand/command
/// and the service /hand/stop. A goal of the hand whose client cancels or dies holds the hand.
/// An emergency stop brakes the arm and holds the hand where it is: what it grips stays gripped.
class RobotActions {
 public:
  RobotActions(graph::Node& node, RobotRunner& robot, EmergencyStopListener& of_arm,
               EmergencyStopListener& of_hand);

 private:
  using HandContext = graph::ActionContext<msgs::MoveHandFeedback>;
  msgs::MoveHandResult move_hand(const msgs::MoveHandGoal& goal, HandContext& context);
  void command(const msgs::JointCommand& command);

  graph::Node& node_;
  RobotRunner& robot_;
  const EmergencyStopListener& emergency_;
  ArmAction arm_;
  graph::Service stop_hand_;
  graph::Subscription command_;
  std::string said_;  // of the last command that was refused or ignored, once
  graph::ActionServer hand_;
  EmergencyStopListener::Action emergency_stop_;
};

}  // namespace prehend::nodes
