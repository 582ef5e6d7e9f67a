#pragma once

#include <filesystem>

#include "prehend/geometry/triangle_mesh.h"

// Internal to prehend::mesh_files.
namespace prehend::geometry {

/// Reads an OFF mesh of text (https://www.geom.uiuc.edu/software/geomview, "OFF Files"), times
/// `scale`; of vertices with colours or normals their places, convex polygons as fans. Our own
/// because Assimp allocates what the header promises, and ends the program for a face without
/// corners. Indices are not checked here. @throws InputError for a foreign or truncated file, a
/// binary one, and one of four dimensions.
TriangleMesh read_off_mesh(const std::filesystem::path& path, double scale);

}  // namespace prehend::geometry
