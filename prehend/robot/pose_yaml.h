#pragma once

#include <filesystem>
#include <string>

#include <yaml-cpp/yaml.h>

#include "prehend/geometry/rigid_transform.h"

namespace prehend::robot {

/// Reads a pose `{xyz: [x, y, z], rpy: [roll, pitch, yaw]}` [m and rad] as URDF means it: turned
/// about the fixed axes x, y and z in this order. Missing keys are 0. `place` names it in errors.
/// @throws geometry::InputError "file:line: ...".
geometry::RigidTransform read_pose(const YAML::Node& node, const std::filesystem::path& path,
                                   const std::string& place);

}  // namespace prehend::robot
