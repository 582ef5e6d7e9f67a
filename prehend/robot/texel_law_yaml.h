#pragma once

#include <filesystem>
#include <string>

#include <yaml-cpp/yaml.h>

#include "prehend/contact/texel_law.h"

namespace prehend::robot {

/// Reads a map of the fields of TexelLaw over `law`; missing keys keep what is there. normal_law:
/// linear, hunt_crossley or tabulated (with curve: [[depth in m, force in N], ...], the first
/// [0, 0]); bristle_law: lugre or elasto_plastic; creep: [{share, time in s}, ...] and hysteresis:
/// [{share, depth in m}, ...] of FoamMemory. `place` names the map in errors.
/// @throws geometry::InputError "file:line: ...": unknown key, wrong type, a law that is none.
void read_texel_law(const YAML::Node& node, const std::filesystem::path& file,
                    const std::string& place, contact::TexelLaw& law);

}  // namespace prehend::robot
