#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/formats/loss_report.h"
#include "prehend/robot/formats/robot_description.h"

namespace prehend::robot::formats {

/// Whether a box, ball, cylinder or capsule is flat, negative or not a number.
bool has_no_size(const Shape& shape);

/// Surfaces of a robot's shapes; each file is read once.
class ShapeMeshes {
 public:
  /// Meshes are found from `folder`, the robot's file's, by find_mesh_file().
  explicit ShapeMeshes(std::filesystem::path folder) : folder_(std::move(folder)) {}

  /// The surface of a shape of any kind, in its frame S [m], scale applied; of a plane none.
  /// @throws geometry::InputError naming the file of a mesh that is not there or not read, and for
  /// a shape that has_no_size().
  geometry::TriangleMesh of(const Shape& shape);
  /// A file's mesh as it stands in it, in its units: all that geometry::read_mesh_file() reads, and
  /// Inventor and VRML. @throws as of()
  const geometry::TriangleMesh& read(const std::string& name);

 private:
  std::filesystem::path folder_;
  std::map<std::string, geometry::TriangleMesh> read_;  // by the file's own path
};

/// A mesh to be written, in metres; `file` is relative to the robot's.
struct MeshFile {
  std::filesystem::path file;
  geometry::TriangleMesh mesh;
};

enum class TakenMeshes {
  kForeign,  // those within the robot's file, and those that other programs rarely read: Inventor,
             // VRML
  kAll,
  kEmbedded,  // none: all are loaded, to be within the robot's file
};

/// Meshes as STL files of the folder `name`_meshes, after which the shapes are named; `loss` says
/// of each. What cannot be read stays as it is named, from the folder `from`. Of kEmbedded there
/// are no files: the shapes have the meshes themselves.
std::vector<MeshFile> take_out_meshes(RobotDescription& robot, const std::filesystem::path& from,
                                      const std::string& name, LossReport& loss,
                                      TakenMeshes taken = TakenMeshes::kForeign);
/// @throws geometry::InputError for a folder that cannot be written.
void write_meshes(const std::vector<MeshFile>& meshes, const std::filesystem::path& folder);

}  // namespace prehend::robot::formats
