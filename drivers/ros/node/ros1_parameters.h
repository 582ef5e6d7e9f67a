#pragma once

#include <string>

#include "drivers/ros/node/bridge.h"

namespace prehend::drivers::ros_link {

/// Declares `ros_name`, `master` and `patience`. @returns what connects by them
Connect declare_roscpp(graph::Node& node, const std::string& ros_name);

}  // namespace prehend::drivers::ros_link
