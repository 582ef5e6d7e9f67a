#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "prehend/robot/formats/robot_description.h"

namespace prehend::robot::formats {

/// What is wrong, or suspicious, of a description, for physics and for grasping.
struct ModelFinding {
  enum class Level { kWarning, kError } level = Level::kWarning;
  std::string place;  // "link 'palm'"
  std::string what;
  std::string mend;
};

/// Checks masses and inertias (each principal one at most the sum of the others; no wider than the
/// link's shapes allow), limits, efforts, speeds, axes, couplings, shapes and their meshes: whether
/// they are there, in metres, and mirrored; whether links overlap at rest, as overlaps_at_rest().
/// @param folder from which meshes are found, as of find_mesh_file()
std::vector<ModelFinding> check_model(const RobotDescription& robot,
                                      const std::filesystem::path& folder);

/// Mends what has one safe mend: limits that are exchanged, inertias that are not symmetric, axes
/// that are not of unit length, inertials without mass (taken away), inertias that no body has, of
/// links with a mass and a shape (as if it filled the shape evenly). @returns what was mended
/// @param folder as of check_model()
std::vector<std::string> mend_model(RobotDescription& robot, const std::filesystem::path& folder);

/// By how much two descriptions differ in what they do.
struct ModelDifference {
  std::vector<std::string> only_first, only_second;  // links and joints, by name
  double place = 0, turn = 0;       // m, rad: greatest of any link in common, at random positions
  std::string where;                // that link
  std::vector<std::string> others;  // masses, limits, efforts, in words
};

/// @param samples random positions within the joints' limits that both have, by a fixed seed
ModelDifference difference(const RobotDescription& first, const RobotDescription& second,
                           int samples = 1000);

}  // namespace prehend::robot::formats
