#pragma once

#include <string>
#include <vector>

#include "prehend/robot/platform.h"
#include "prehend/simulation/clutter_scene.h"

namespace prehend::eval {

/// Names of the bodies that the robot could grasp if it knew their shape and each lay there alone:
/// the planner finds a grasp of the true mesh, and the arm from its home the way to it. What others
/// bear, lean on or hide counts, too. Half a second a body.
/// @throws geometry::InputError for a platform without that home.
std::vector<std::string> graspable_bodies(const std::vector<simulation::ClutterSolid>& solids,
                                          const std::vector<simulation::ClutterBody>& bodies,
                                          const robot::Platform& platform);

}  // namespace prehend::eval
