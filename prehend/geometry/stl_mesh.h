#pragma once

#include <cstddef>
#include <filesystem>

#include "prehend/geometry/triangle_mesh.h"

// Internal to prehend::mesh_files.
namespace prehend::geometry {

/// Whether the STL file of `size` bytes is binary; else it is text.
/// @throws InputError for one that is truncated or no STL file.
bool is_binary_stl(const std::filesystem::path& path, std::size_t size);

/// The triangles of a binary STL file, each with vertices of its own, times `scale`.
/// @pre is_binary_stl(). Cost: that of reading the file.
TriangleMesh read_binary_stl(const std::filesystem::path& path, double scale);

}  // namespace prehend::geometry
