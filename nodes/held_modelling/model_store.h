#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/grasp/known/grasp_database.h"

namespace prehend::nodes {

/// What becomes of an object that was seen all round: a file of its mesh in the folder of known
/// objects, and its grasps in their database.
class ModelStore {
 public:
  /// @param folder made where it is not there. @param database empty: grasps are not kept.
  /// @throws geometry::InputError when the folder cannot be made, or as grasp::GraspDatabase.
  ModelStore(std::filesystem::path folder, const std::filesystem::path& database);

  /// A grasp of it in the world, as the object stood when it was first seen.
  struct Grasp {
    geometry::RigidTransform X_WG;
    grasp::StoredGrasp stored;  // its X_OG is filled here
  };
  /// Writes the mesh under the first free name object-1.ply, object-2.ply, ..., standing on its
  /// frame's origin, and the grasps. @return the file.
  /// @throws geometry::InputError when one of them cannot be written.
  std::filesystem::path store(const geometry::TriangleMesh& mesh_W, const geometry::Plane& table_W,
                              const std::string& hand, std::vector<Grasp> grasps);

 private:
  std::filesystem::path folder_;
  std::optional<grasp::GraspDatabase> database_;
};

}  // namespace prehend::nodes
