#pragma once

#include <array>
#include <filesystem>
#include <vector>

#include "prehend/geometry/triangle_mesh.h"

// Internal to prehend::mesh_files.
namespace prehend::geometry {

/// Red, green and blue, 0 to 255, as a PLY has them; empty: it has none.
struct PlyColors {
  std::vector<std::array<int, 3>> vertices, triangles;
};

/// Reads vertices and faces of a PLY mesh (ascii or binary, either byte order), times `scale`;
/// other elements are skipped, convex polygons are cut into fans. Our own because Assimp reads
/// beyond the end of a truncated file and takes indices without a vertex. Indices are not checked
/// here. `colors`, unless null, takes theirs; floats are from 0 to 1.
/// @throws InputError for a missing, foreign or truncated file.
TriangleMesh read_ply_mesh(const std::filesystem::path& path, double scale,
                           PlyColors* colors = nullptr);

}  // namespace prehend::geometry
