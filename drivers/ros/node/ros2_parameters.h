#pragma once

#include "drivers/ros/node/bridge.h"

namespace prehend::drivers::ros_link {

/// Declares `domain` and `network`. @returns what connects by them
Connect declare_dds(graph::Node& node);

}  // namespace prehend::drivers::ros_link
