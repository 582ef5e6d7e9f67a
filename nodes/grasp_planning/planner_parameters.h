#pragma once

#include <memory>

#include "nodes/grasp_planning/platform_planning.h"

// The parameters of grasp_planning that say for whom and how it plans.
namespace prehend::nodes {

/// Declares the platform, its arm's and its hand's parameters, the front that may choose some of
/// them, and the task, and makes the planner of what they say.
/// @throws geometry::InputError and std::invalid_argument naming a parameter that does not apply or
/// a file that cannot be read.
std::unique_ptr<PlatformPlanning> declare_platform(graph::Node& node);

}  // namespace prehend::nodes
