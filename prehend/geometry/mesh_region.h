#pragma once

#include <array>
#include <filesystem>
#include <optional>
#include <string>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::geometry {

/// By what a part of a mesh file's surface is told from the rest. At most one is set; none: all of
/// it.
struct MeshRegion {
  std::string group = {};     // of an OBJ: a name of `g` or `o`
  std::string material = {};  // of an OBJ: a name of `usemtl`
  /// Of a PLY: red, green, blue, 0 to 255, of its faces, or of all three corners where faces have
  /// no colour. Each may be 2 off, as programs round.
  std::optional<std::array<int, 3>> color = std::nullopt;

  bool is_all() const { return group.empty() && material.empty() && !color; }
};

/// The triangles of `region` with the vertices that they use, in the file's unit; polygons are cut
/// into fans. Vertices at one place stay as many as the file has. A region that is all of it may be
/// of any file that read_mesh_file() reads.
/// @throws InputError naming the file: one that cannot be read or is damaged; one of the wrong
/// kind; a region that is not there, with the nearest there is; a face whose vertex does not exist.
TriangleMesh read_mesh_region(const std::filesystem::path& path, const MeshRegion& region);

}  // namespace prehend::geometry
