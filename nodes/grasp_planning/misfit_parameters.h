#pragma once

#include "prehend/control/task.h"
#include "prehend/fidelity/front.h"
#include "prehend/graph/node.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// Refuses the parameters that were given to grasp_planning but mean nothing for the platform: of
/// the parallel gripper when its hand has fingers, and what a measured front chooses in their
/// place, where `front` does (null: nothing is chosen).
/// @throws std::invalid_argument naming the parameter, why it does not apply, and the mend.
void refuse_what_does_not_apply(const graph::Node& node, const robot::Platform& platform,
                                const fidelity::Front* front);

/// The same of views of what is held, where the task does not inspect, and of looks from elsewhere,
/// where the arm carries no camera or the task has no such look.
void refuse_views(const graph::Node& node, const control::Task& task,
                  const robot::Platform& platform);

}  // namespace prehend::nodes
