#pragma once

#include <filesystem>

#include <yaml-cpp/yaml.h>

#include "prehend/robot/hand_model.h"

namespace prehend::robot {

/// Reads the map `pads` of a hand's file into `hand`, whose links are known. `path` is that file;
/// meshes that a pad names lie beside it, those of links are found from `urdf`'s folder.
/// @throws geometry::InputError "file:line: ..." with the nearest name and the mend: also for a
/// region that is not there, a grid that misses its link, or pads that overlap.
void read_hand_pads(const YAML::Node& node, const std::filesystem::path& path,
                    const std::filesystem::path& urdf, HandModel& hand);

}  // namespace prehend::robot
