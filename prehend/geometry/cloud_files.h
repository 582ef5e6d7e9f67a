#pragma once

#include <filesystem>
#include <optional>

#include "prehend/geometry/point_cloud.h"

namespace prehend::geometry {

/// A cloud file's content. PCD's VIEWPOINT header is returned as written: files lie about it.
struct CloudFile {
  PointCloud cloud;                         // in the file's frame
  std::optional<RigidTransform> viewpoint;  // pose of the sensor in that frame, from the header
  bool has_labels = false;
  std::vector<std::uint32_t> labels;  // n or empty, the file's `label` field
};

/// Reads a .pcd (ascii, binary, binary_compressed) or .ply cloud. Metres are assumed.
/// @throws InputError for a missing, truncated, foreign or empty file and for one without x, y, z;
/// nothing larger than the file can account for is allocated.
CloudFile read_cloud_file(const std::filesystem::path& path);

/// Writes a binary .pcd or .ply by the file name's ending. @throws InputError when it cannot.
void write_cloud_file(const std::filesystem::path& path, const PointCloud& cloud,
                      const RigidTransform& viewpoint = RigidTransform::Identity());

}  // namespace prehend::geometry
