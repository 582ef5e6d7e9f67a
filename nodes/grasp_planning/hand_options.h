#pragma once

#include "prehend/graph/node.h"
#include "prehend/grasp/hand_planner.h"
#include "prehend/grasp/planner.h"

namespace prehend::nodes {

/// What the node plans for.
enum class Robot {
  kGripper,         // a parallel gripper on its carrier
  kArmWithPads,     // a platform whose hand is a parallel gripper
  kArmWithFingers,  // any other platform
};

/// Refuses the parameters that were given to grasp_planning but mean nothing beside the others: of
/// the parallel gripper when a hand with fingers is planned for, of the platform when none is, and
/// what a measured front chooses in their place.
/// @throws std::invalid_argument naming the parameter, why it does not apply, and the mend.
void refuse_what_does_not_apply(const graph::Node& node, Robot robot, bool front_chooses);

/// Options of planning with a hand: the hand's own defaults, and of `common` what the node was
/// given. Given generators are used alone, without further ones.
grasp::HandPlannerOptions hand_options(const graph::Node& node,
                                       const grasp::PlannerOptions& common);

}  // namespace prehend::nodes
