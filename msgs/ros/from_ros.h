#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/camera.pb.h"
#include "msgs/joints.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/geometry/image.h"
#include "prehend/recording/ros_message.h"

/// Messages of ROS as prehend's own. Both versions' types have the same fields. All throw
/// geometry::InputError for what cannot be (sizes that do not fit the data, an encoding that is not
/// known), recording::RosError for a field that is missing.
namespace prehend::ros {

/// Types that from_ros() knows, as "sensor_msgs/Image", sorted.
const std::vector<std::string>& ros_types();

/// A message of one of ros_types() as prehend has it:
///   sensor_msgs/Image, CompressedImage  msgs::Image, or msgs::DepthImage where it is depth (16UC1,
///                                       mono16 [mm], 32FC1 [m], compressedDepth as PNG)
///   sensor_msgs/CameraInfo              msgs::CameraInfo of the rectified image
///   sensor_msgs/PointCloud2             msgs::PointCloud; fields x y z, rgb or rgba, normals
///   sensor_msgs/JointState              msgs::JointState
///   geometry_msgs/WrenchStamped         msgs::Wrench
///   rosgraph_msgs/Clock                 msgs::Clock
///   rosgraph_msgs/Log, rcl_interfaces/Log  msgs::graph::LogLine
/// @returns nullptr for another type.
std::unique_ptr<google::protobuf::Message> from_ros(const std::string& type,
                                                    const recording::RosValue& message);

/// [ns] A time or a duration.
std::int64_t ros_nanoseconds(const recording::RosValue& time);
/// [ns] A std_msgs/Header's stamp.
std::int64_t ros_stamp(const recording::RosValue& header);

/// Two images of a rectified pair as one message, with the left one's header.
/// @throws geometry::InputError when their sizes differ.
msgs::StereoPair stereo_pair(const msgs::Image& left, const msgs::Image& right);

/// A depth image with the colours of an image that is registered to it.
/// @throws geometry::InputError when their sizes differ.
msgs::DepthImage colored(const msgs::DepthImage& depth, const msgs::Image& color);

}  // namespace prehend::ros
