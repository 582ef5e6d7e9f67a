#pragma once

#include "prehend/graph/node.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// Refuses the parameters that were given to grasp_planning but mean nothing for the platform: of
/// the parallel gripper when its hand has fingers, and what a measured front chooses in their
/// place.
/// @throws std::invalid_argument naming the parameter, why it does not apply, and the mend.
void refuse_what_does_not_apply(const graph::Node& node, const robot::Platform& platform,
                                bool front_chooses);

}  // namespace prehend::nodes
