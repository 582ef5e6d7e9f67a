#pragma once

#include <filesystem>

#include "nodes/report/collected.h"

namespace prehend::nodes {

/// Writes object_K.ply, .obj and .stl of every predicted mesh (metres, world frame) and
/// object_K_grasps.json, its GraspPlan as protobuf's JSON, into `folder`, made where it is not
/// there. @throws geometry::InputError, std::runtime_error naming a file that cannot be written.
void save_predictions(const Collected& collected, const std::filesystem::path& folder);

}  // namespace prehend::nodes
