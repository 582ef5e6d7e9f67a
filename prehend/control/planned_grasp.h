#pragma once

#include <optional>

#include "prehend/control/arm_cycle.h"
#include "prehend/planning/platform_plan.h"

namespace prehend::control {

/// What the cycle executes of a planned grasp: its pose, the arm's segments sampled every 20 ms,
/// how the hand closes (its joints with the prefix hand_ that they have in the platform), and what
/// is to be felt. @throws geometry::InputError for an unknown preshape.
ArmGrasp arm_grasp(const robot::Platform& platform, const planning::PlannedPick& pick);

/// What the cycle executes of a planned probe, after the grasps of its plan; none without one.
std::optional<ArmGrasp> arm_probe(const robot::Platform& platform,
                                  const planning::PlannedProbe& probe);

/// The same of a planned push.
std::optional<ArmGrasp> arm_push(const robot::Platform& platform,
                                 const planning::PlannedPush& push);

/// The way of the arm to a planned look, sampled as a grasp's segments; without points: there is
/// none.
JointTrajectory look_way(const robot::Platform& platform, const planning::PlannedLook& look);

/// What a cycle goes by: the best of the plan's choices; without any it grasps.
Advice advice_of(const robot::Platform& platform, const planning::PlatformPlan& plan);

}  // namespace prehend::control
