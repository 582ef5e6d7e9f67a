#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/rigid_transform.h"

// Headers of PCD and PLY files, checked against the size of the file before a library reads (and
// allocates for) what they promise. Internal to prehend::mesh_files and
// prehend::geometry_files.
namespace prehend::geometry {

struct PcdHeader {
  std::vector<std::string> fields;
  std::size_t width = 0;
  std::size_t height = 0;
  std::size_t points = 0;
  std::string encoding;                     // ascii, binary, binary_compressed
  std::optional<RigidTransform> viewpoint;  // absent also when its quaternion is no rotation
};

/// @throws InputError for a missing, foreign, empty or truncated file, for a header that
/// contradicts itself or the file's size, and for one without points or without x, y, z.
PcdHeader read_pcd_header(const std::filesystem::path& path);

enum class PlyNumber { kInt8, kUint8, kInt16, kUint16, kInt32, kUint32, kFloat32, kFloat64 };

struct PlyProperty {
  std::string name;
  PlyNumber type = PlyNumber::kFloat32;  // of a value, or of a list's entries
  std::optional<PlyNumber> list_length;  // set: a list
};

struct PlyElement {
  std::string name;
  std::size_t count = 0;
  std::vector<PlyProperty> properties;
};

struct PlyHeader {
  std::string format;  // ascii, binary_little_endian, binary_big_endian
  std::vector<PlyElement> elements;
  std::size_t body_offset = 0;  // bytes before the first element
  std::size_t vertices = 0;
  std::size_t faces = 0;
  bool has_camera = false;  // PCL's element with the viewpoint
};

/// Bytes of a number in a binary PLY file.
std::size_t size_of(PlyNumber type);

/// @throws InputError like read_pcd_header.
PlyHeader read_ply_header(const std::filesystem::path& path);

/// @throws InputError when `path` is missing, not a regular file, empty or not readable.
std::size_t checked_file_size(const std::filesystem::path& path);

/// The file name's ending in lower case with the dot, e.g. ".pcd".
std::string lower_case_extension(const std::filesystem::path& path);

}  // namespace prehend::geometry
