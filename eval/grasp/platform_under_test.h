#pragma once

#include <filesystem>

#include "eval/grasp/hand_under_test.h"
#include "prehend/robot/platform.h"

namespace prehend::eval {

/// A platform's arm and hand: plans with the arm's motion (planning::PlatformPlanner), executes
/// with the shipped cycle (control::CycleInWorld) in a world with the wrist sensor's noise, and
/// looks again after a failed attempt. `lifted` is by 50 mm at least, put down, and said to be.
/// @param reacts as control::ArmCycleOptions::reacts.
/// @throws geometry::InputError as robot::read_platform(), as in_reach(), and for a platform whose
/// gripper is moved through /gripper: that has another world.
HandUnderTest platform_under_test(const std::filesystem::path& file, bool reacts);

/// The platform, moved along the table where its arm does not reach the world's origin, at which
/// evaluated objects stand, from above: to where the middle of what it reaches is there.
/// @throws geometry::InputError for an arm that reaches nothing on the table from above.
robot::Platform in_reach(robot::Platform platform);

}  // namespace prehend::eval
