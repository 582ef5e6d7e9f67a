#pragma once

#include <memory>
#include <string>

#include "drivers/ros/transport/ros_peer.h"

namespace prehend::drivers::ros_link {

/// ROS 1 by roscpp, as one node of its graph; one a process.
/// @param name of the node in ROS. @param master its URI; empty: ROS_MASTER_URI.
/// @param patience s, to wait for the master.
/// @throws std::runtime_error when no master answers.
std::unique_ptr<RosPeer> connect_roscpp(const std::string& name, const std::string& master,
                                        double patience, RosProblem tell);

}  // namespace prehend::drivers::ros_link
