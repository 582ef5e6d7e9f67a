#pragma once

#include <filesystem>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::geometry {

/// Reads a COLLADA (.dae), glTF (.gltf, .glb), OBJ or text STL (by Assimp), OFF, binary STL or PLY
/// mesh, all parts as one, polygons as triangles, times `scale` (metres per file unit). COLLADA
/// says its unit, which is applied before `scale`; its axes stay as they are, whichever of them the
/// file calls up, as ROS's tools have it. glTF is in metres with y up, and becomes z up, as Drake
/// and Gazebo have it. STL's repeated vertices become one. Cost of 2 million triangles: some tenths
/// of a second from binary files, seconds by Assimp. @throws InputError for a missing, foreign,
/// truncated or empty file, and for what grows beyond measure (mesh_guards.h).
TriangleMesh read_mesh_file(const std::filesystem::path& path, double scale = 1.0);

/// Writes .obj, .ply (binary) or .stl (binary) by the file name's ending. @throws InputError when
/// the folder does not exist, the disk is full or the ending is unknown.
void write_mesh_file(const std::filesystem::path& path, const TriangleMesh& mesh);

}  // namespace prehend::geometry
