#pragma once

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/ros/transport/ros_peer.h"

namespace prehend::drivers::ros_link {

/// What a bridge exchanges, as its file says (config/ros/README.md has every key).
struct Mapping {
  struct Topic {
    std::string prehend, ros, type;  // names on both sides, and ROS's type
    RosQos qos;
  };
  /// Pictures of ROS, as nodes of prehend look at them.
  struct Camera {
    std::vector<std::string> stereo;  // left and right, or none
    std::string depth, color;         // instead of `stereo`
    std::string world_frame;          // in which the camera's pose is told, by TF; empty: it is not
    bool is_reliable = false;
  };
  struct Arm {
    std::string action;        // FollowJointTrajectory
    std::string joint_states;  // with the arm's joints
    std::map<std::string, std::string>
        joints;              // ROS's names by the platform's; others are the same
    double settle_time = 5;  // s, after a trajectory's end, in which the action has to end
    double loss_time = 0.5;  // s without joint states, then the arm is stopped
  };
  struct Gripper {
    std::string action;        // GripperCommand
    std::string joint_states;  // with its joint
    std::string joint;
    /// position = closed_position + opening * position_per_opening
    double position_per_opening = 1, closed_position = 0;
    double effort_per_current = 1;  // N or N m, as its driver has it, of one A
    double loss_time = 0.5;         // s without joint states, then motions are refused
  };

  std::vector<Topic> to_ros, from_ros;
  std::optional<Camera> camera;
  std::optional<Arm> arm;
  std::optional<Gripper> gripper;
  std::string pick;  // name of the action that picks; empty: none
};

/// @throws geometry::InputError "file:line: what is wrong" with the mend: an unknown key or type, a
/// name that is none, a topic that would go round in a circle, ROS 2's quality of service with
/// ROS 1.
Mapping read_mapping(const std::filesystem::path& path, ros::Version version);

}  // namespace prehend::drivers::ros_link
