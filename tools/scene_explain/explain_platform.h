#pragma once

#include <filesystem>

#include "prehend/simulation/explain.h"

namespace prehend::tools {

/// What motions and grasps of a platform are planned with: its joints, hand and pads, the balls
/// that stand for its links, which of them are tested against each other, and what is left out.
/// @throws geometry::InputError for a file that is no platform, and as make_robot_spheres().
simulation::Explanation explain_platform(const std::filesystem::path& file);

}  // namespace prehend::tools
