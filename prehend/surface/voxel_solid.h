#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// A solid as the voxels that it fills, and how far each other voxel is from it. Voxel (i, j, k) is
/// the cube about the point (i, j, k), in voxels; x fastest.
struct VoxelSolid {
  Eigen::Vector3i size = Eigen::Vector3i::Zero();
  std::vector<bool> filled;
  /// From the voxel's centre to that of the nearest filled one, 0 in filled ones.
  std::vector<float> distance;

  std::size_t index(int x, int y, int z) const {
    return (static_cast<std::size_t>(z) * size.y() + y) * size.x() + x;
  }
};

/// The voxels whose centre is inside the closed `mesh` (the surface crosses the row along x with
/// positive winding number) and those that the surface passes through, so that no wall is too thin
/// to be seen; distances by the exact transform of Felzenszwalb and Huttenlocher ("Distance
/// Transforms of Sampled Functions", 2012). `mesh` in voxels, within [0, size - 1]. O(voxels +
/// triangles + area).
VoxelSolid voxelized(const geometry::TriangleMesh& mesh, const Eigen::Vector3i& size);

}  // namespace prehend::surface
