#pragma once

#include <functional>
#include <memory>
#include <string>

#include "drivers/ros/transport/ros_peer.h"
#include "prehend/graph/node.h"

namespace prehend::drivers::ros_link {

/// Connects to ROS; the node's own parameters are declared already.
using Connect = std::function<std::unique_ptr<RosPeer>(RosProblem tell)>;

/// What both bridges are: parameters `mapping`, `platform`, `gripper`, then topics both ways, an
/// arm and a gripper whose drivers are ROS's, and the action that picks, as the mapping says, until
/// the node is stopped. What does not fit together is logged, and shown as the node's health.
void run_bridge(graph::Node& node, ros::Version version, const Connect& connect);

}  // namespace prehend::drivers::ros_link
