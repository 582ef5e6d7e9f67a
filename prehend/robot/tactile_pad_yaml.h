#pragma once

#include <filesystem>
#include <string>

#include <yaml-cpp/yaml.h>

#include "prehend/robot/gripper_model.h"

namespace prehend::robot {

/// Reads a map of the fields of TactilePadModel over `pad`; missing keys keep what is there. The
/// values are not checked, see validate(). `place` names the map in errors.
/// @throws geometry::InputError "file:line: ...": unknown key or wrong type.
void read_tactile_pad(const YAML::Node& node, const std::filesystem::path& path,
                      const std::string& place, TactilePadModel& pad);

}  // namespace prehend::robot
