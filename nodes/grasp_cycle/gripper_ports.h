#pragma once

#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/motion_goal/motion_goal.h"
#include "prehend/control/pad_gripper.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// The gripper behind the action /gripper/move and the topic /gripper/command. The device's
/// watchdog stops it 0.2 s after the last velocity command, so the cycle repeats them.
class GripperActions : public control::GripperPort {
 public:
  explicit GripperActions(graph::Node& node);
  void move_to(double opening, double speed) override;
  control::MotionStatus motion() override;
  double answer_age() override { return goal_.answer_age(); }
  void command_velocity(double speed, double current_limit) override;
  void stop() override;

 private:
  void publish(msgs::GripperCommand::Mode mode, double value, double current_limit);

  graph::Node& node_;
  graph::Publisher<msgs::GripperCommand> commands_;
  MotionGoal<msgs::MoveGripperGoal, msgs::MoveGripperFeedback, msgs::MoveGripperResult> goal_;
};

}  // namespace prehend::nodes
