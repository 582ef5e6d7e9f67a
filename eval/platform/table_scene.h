#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "eval/data_sets.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval {

/// A body of a generated scene.
struct PlacedBody {
  std::string name;
  std::shared_ptr<const geometry::TriangleMesh> mesh_B;  // as it rests, on z = 0, centred
  double mass = 0;                                       // kg
  double x = 0, y = 0;                                   // m
  double yaw = 0;                                        // rad
};

/// The data set's body as it comes to rest by itself, at the origin.
PlacedBody resting_body(const DataSet& set);

/// One to four bodies on a table, apart from each other.
struct TableScene {
  std::string name;
  std::vector<PlacedBody> bodies;
};

/// `count` scenes of the bodies of `sets` that stand alone and are no larger than 0.3 m, at random
/// places in front of the camera, at least 5 cm apart. Same sets, count and seed, same scenes.
/// @throws geometry::InputError when no set will do.
std::vector<TableScene> make_table_scenes(const std::vector<DataSet>& sets, int count,
                                          std::uint64_t seed);

/// Writes `folder`/scene.yaml and its meshes, for the simulation and `prehend explain`.
/// @return the scene's file.
std::filesystem::path write_scene(const TableScene& scene, const std::filesystem::path& folder);

}  // namespace prehend::eval
