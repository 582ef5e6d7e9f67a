#pragma once

#include <memory>
#include <string>
#include <vector>

#include "drivers/ros/driver/ros_arm.h"
#include "drivers/ros/driver/ros_gripper.h"
#include "drivers/wire/node/joint_report.h"
#include "drivers/wire/node/wall_timer.h"
#include "msgs/actions.pb.h"
#include "msgs/sensors.pb.h"
#include "nodes/arm_action/arm_action.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::ros_link {

/// What an arm of ROS offers here: /arm/follow, /arm/stop, /joint_states.
class ArmOffer {
 public:
  /// All of these live longer. @param other_joints as of JointReport
  ArmOffer(graph::Node& node, RosArm& arm, nodes::EmergencyStopListener& emergency,
           const std::string& other_joints);

 private:
  void tell();

  RosArm& arm_;
  JointReport joints_;
  graph::Subscription wrench_;
  nodes::ArmAction action_;
  WallTimer timer_;
};

/// What a gripper of ROS offers here: /gripper/model, /gripper/state, /gripper/move, /gripper/stop,
/// and of /gripper/command what takes it to an opening or stops it.
class GripperOffer {
 public:
  /// All of these live longer. @param file the gripper's model
  GripperOffer(graph::Node& node, RosGripper& gripper, nodes::EmergencyStopListener& emergency,
               const std::string& file);

 private:
  using Context = graph::ActionContext<msgs::MoveGripperFeedback>;
  void tell();
  void command(const msgs::GripperCommand& command);
  msgs::MoveGripperResult move(const msgs::MoveGripperGoal& goal, Context& context);

  graph::Node& node_;
  RosGripper& gripper_;
  nodes::EmergencyStopListener& emergency_;
  std::atomic<std::int64_t> action_stamp_ = 0;  // ns
  graph::Publisher<msgs::GripperDescription> model_;
  graph::Publisher<msgs::GripperState> states_;
  graph::Service stop_;
  graph::Subscription commands_;
  graph::ActionServer move_;
  nodes::EmergencyStopListener::Action emergency_stop_;
  WallTimer timer_;
};

}  // namespace prehend::drivers::ros_link
