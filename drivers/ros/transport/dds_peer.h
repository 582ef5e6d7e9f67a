#pragma once

#include <memory>
#include <string>

#include "drivers/ros/transport/ros_peer.h"

namespace prehend::drivers::ros_link {

struct DdsOptions {
  int domain = 0;  // ROS_DOMAIN_ID, 0 to 232
  /// "loopback": this machine alone, by 127.0.0.1; "environment": as CYCLONEDDS_URI says; else the
  /// name or address of the network interface.
  std::string network = "loopback";
};

/// ROS 2 without ROS: CycloneDDS with ROS 2's names, types and quality of service.
/// @throws std::runtime_error in words when there is no such interface or no socket to be had.
std::unique_ptr<RosPeer> connect_dds(const DdsOptions& options, RosProblem tell);

/// "rt/camera/points", "rq/arm/_action/send_goalRequest", "rr/arm/_action/send_goalReply".
std::string dds_topic_name(const std::string& name, RosChannel channel);

}  // namespace prehend::drivers::ros_link
