#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/rigid_transform.h"

// Headers of PCD and PLY files, checked against the size of the file before a library reads (and
// allocates for) what they promise. Internal to prehend::geometry_files.
namespace prehend::geometry {

struct PcdHeader {
  std::vector<std::string> fields;
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t points = 0;
  std::string encoding;  // ascii, binary, binary_compressed
  std::optional<RigidTransform> viewpoint;  // absent also when its quaternion is no rotation
};

/// @throws InputError for a missing, foreign, empty or truncated file, for a header that
/// contradicts itself or the file's size, and for one without points or without x, y, z.
PcdHeader read_pcd_header(const std::filesystem::path& path);

struct PlyHeader {
  std::size_t vertices = 0;
  std::size_t faces = 0;
  bool has_camera = false;  // PCL's element with the viewpoint
};

/// @throws InputError like read_pcd_header.
PlyHeader read_ply_header(const std::filesystem::path& path);

/// @throws InputError when `path` is missing, not a regular file, empty or not readable.
std::size_t checked_file_size(const std::filesystem::path& path);

/// The file name's ending in lower case with the dot, e.g. ".pcd".
std::string lower_case_extension(const std::filesystem::path& path);

}  // namespace prehend::geometry
