#pragma once

#include <string>
#include <vector>

#include "prehend/grasp/grasp.h"
#include "prehend/planning/platform_pick.h"

// A straight way of the hand that is to touch something, and grasps nothing.
namespace prehend::planning {

/// plan_platform_pick() of the first of `ends` that the arm can make, of which nothing is left but
/// the reach and the straight approach to it. @param speed m/s, > 0, of the hand on that.
/// @throws as plan_platform_pick().
PlatformPick plan_straight_way(const robot::Platform& platform, const robot::Positions& start,
                               const std::vector<PlatformGrasp>& ends, const PlatformScene& scene,
                               const PlatformPickOptions& arm, double speed);

/// Where the hand is at the end of such a way, and how it comes there, as a grasp that holds
/// nothing. @param made_by its `generator`.
grasp::Grasp hand_at_end(const PlatformGrasp& end, const std::string& made_by);

}  // namespace prehend::planning
