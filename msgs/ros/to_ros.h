#pragma once

#include <string>
#include <vector>

#include "msgs/ros/definitions.h"

namespace google::protobuf {
class Descriptor;
class Message;
}  // namespace google::protobuf

namespace prehend::ros {

/// What messages of `type` become in ROS, sorted; empty: nothing. What is drawn goes by the types
/// of viewers (msgs/views), whose clouds, pictures, frames and log these are:
///   foxglove.PointCloud         sensor_msgs/PointCloud2: colours as `rgb`, as PCL has them
///   foxglove.RawImage           sensor_msgs/Image
///   foxglove.CompressedImage    sensor_msgs/CompressedImage
///   foxglove.FrameTransforms    tf2_msgs/TFMessage
///   foxglove.Log                rosgraph_msgs/Log of ROS 1, rcl_interfaces/Log of ROS 2
///   prehend.msgs.CameraInfo     sensor_msgs/CameraInfo, of the left camera of a stereo one
///   prehend.msgs.JointState     sensor_msgs/JointState
///   prehend.msgs.Wrench         geometry_msgs/WrenchStamped
///   prehend.msgs.Clock          rosgraph_msgs/Clock
std::vector<std::string> types_in_ros(const google::protobuf::Descriptor& type, Version version);

/// The message as bytes of the ROS type.
/// @throws recording::RosError when there is no such conversion; geometry::InputError for what ROS
/// cannot have: a size that does not fit the data, a time that its 32 bits of seconds cannot say.
std::string to_ros(const google::protobuf::Message& message, const std::string& type,
                   Version version);

/// A std_msgs/Header. @param stamp ns. @param frame is viewed: it has to live as long as what is
/// returned. @throws geometry::InputError for a time before 1970 or after 2106 (ROS 2: 2038).
recording::RosValue ros_header(std::int64_t stamp, std::string_view frame, Version version);
/// A time or duration of either version. @throws as ros_header();
recording::RosValue ros_time(std::int64_t nanoseconds, Version version);
recording::RosValue ros_duration(std::int64_t nanoseconds);

/// Values for ROS messages. Texts, bytes and numbers are not copied: they stay where they are until
/// the message is written.
recording::RosValue ros_text(std::string_view text);
recording::RosValue ros_integer(std::int64_t number);
recording::RosValue ros_number(double number);
recording::RosValue ros_numbers(const double* data, std::size_t count);
recording::RosValue ros_bytes(std::string_view bytes);
recording::RosValue ros_texts(const std::vector<std::string>& texts);

}  // namespace prehend::ros
