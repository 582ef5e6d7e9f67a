#pragma once

#include <filesystem>

#include "prehend/geometry/triangle_mesh.h"

// Internal to prehend::mesh_files.
namespace prehend::geometry {

/// Reads vertices and faces of a PLY mesh (ascii or binary, either byte order), times `scale`;
/// other elements are skipped, convex polygons are cut into fans. Our own because Assimp reads
/// beyond the end of a truncated file and takes indices without a vertex. Indices are not checked
/// here.
/// @throws InputError for a missing, foreign or truncated file.
TriangleMesh read_ply_mesh(const std::filesystem::path& path, double scale);

}  // namespace prehend::geometry
