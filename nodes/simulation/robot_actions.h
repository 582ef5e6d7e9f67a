#pragma once

#include "msgs/actions.pb.h"
#include "nodes/simulation/robot_runner.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// What moves the simulated arm and hand: actions /arm/follow and /hand/move, services /arm/stop
/// and /hand/stop. Every goal has its own end; one whose client cancels, dies or is preempted by a
/// newer goal brakes the arm within its acceleration limits and holds the hand. A newer trajectory
/// begins where the arm then stands.
class RobotActions {
 public:
  RobotActions(graph::Node& node, RobotRunner& robot);

 private:
  using ArmContext = graph::ActionContext<msgs::FollowTrajectoryFeedback>;
  using HandContext = graph::ActionContext<msgs::MoveHandFeedback>;
  msgs::FollowTrajectoryResult follow(const msgs::FollowTrajectoryGoal& goal, ArmContext& context);
  msgs::MoveHandResult move_hand(const msgs::MoveHandGoal& goal, HandContext& context);
  void brake(std::uint64_t ticket);

  graph::Node& node_;
  RobotRunner& robot_;
  graph::Service stop_arm_, stop_hand_;
  graph::ActionServer arm_, hand_;
};

}  // namespace prehend::nodes
