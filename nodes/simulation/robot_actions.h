#pragma once

#include "msgs/actions.pb.h"
#include "nodes/arm_action/arm_action.h"
#include "nodes/simulation/robot_runner.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// What moves the simulated arm and hand: ArmAction, the action /hand/move, the topic /hand/command
/// and the service /hand/stop. A goal of the hand whose client cancels or dies holds the hand.
class RobotActions {
 public:
  RobotActions(graph::Node& node, RobotRunner& robot);

 private:
  using HandContext = graph::ActionContext<msgs::MoveHandFeedback>;
  msgs::MoveHandResult move_hand(const msgs::MoveHandGoal& goal, HandContext& context);
  void command(const msgs::JointCommand& command);

  graph::Node& node_;
  RobotRunner& robot_;
  ArmAction arm_;
  graph::Service stop_hand_;
  graph::Subscription command_;
  std::string said_;  // of the last command that was refused or ignored, once
  graph::ActionServer hand_;
};

}  // namespace prehend::nodes
