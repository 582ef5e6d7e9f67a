#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "prehend/recording/ros_message.h"

// The message types of ROS that prehend exchanges with it, by their fields (index.ros.org; the
// packages common_msgs, control_msgs, actionlib_msgs, geometry2 and rosgraph_msgs of ROS 1 noetic,
// common_interfaces, control_msgs 4, rcl_interfaces and action_msgs of ROS 2 humble).
namespace prehend::ros {

enum class Version { kRos1, kRos2 };

inline recording::RosEncoding encoding_of(Version version) {
  return version == Version::kRos1 ? recording::RosEncoding::kRos1 : recording::RosEncoding::kCdr;
}

/// An action's types, with what is sent about it: ROS 1 X_Goal is "pkg/XGoal", of ROS 2
/// "pkg/X_Goal". Known: control_msgs/FollowJointTrajectory, control_msgs/GripperCommand,
/// prehend_msgs/Pick.
const std::vector<std::string>& action_types();

/// Names of all types that definition() knows for that version, sorted.
std::vector<std::string> message_types(Version version);
bool has_definition(const std::string& type, Version version);

/// The text of a definition with all that it contains, as recordings and connections carry it.
/// @param type "sensor_msgs/Image". @throws recording::RosError for an unknown one.
std::string definition(const std::string& type, Version version);

/// What reads and writes a type; built once. @throws as definition().
const recording::RosType& type_of(const std::string& type, Version version);

/// The MD5 sum by which ROS 1 tells versions of a type apart (wiki.ros.org/ROS/Technical Overview,
/// "Message serialization and msg MD5 sums"), in hexadecimal. @throws as definition().
std::string md5_sum(const std::string& type);

/// The name of a type as DDS has it: "sensor_msgs::msg::dds_::Image_" (design.ros2.org, "Topic and
/// Service name mapping to DDS"); of actions
/// "control_msgs::action::dds_::FollowJointTrajectory_...".
std::string dds_type_name(const std::string& type);

}  // namespace prehend::ros
