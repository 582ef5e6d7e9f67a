#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/mesh_query.h"
#include "prehend/grasp/closing/distance_kernel.h"

namespace prehend::grasp {

/// Unsigned distances to a surface from blocks of 4 x 4 x 4 nodes: some seven times as fast as
/// SurfaceQuery::nearest() of each node (BM_DistancesOfABlock), as one search finds the triangles
/// that can be nearest to any of them. In single precision: wrong by some 1e-7 of the surface's
/// size. Reentrant.
class DistanceBlocks {
 public:
  /// Keeps a reference to `surface_W` and some 150 bytes a triangle.
  explicit DistanceBlocks(const geometry::SurfaceQuery& surface_W);

  /// Distances [m] from the nodes first_W + cell * (x, y, z) with x, y and z from 0 to 3; those of
  /// a surface without triangles are the largest float. A bound of the distance from the block's
  /// middle (`most` [m]) makes it faster; a wrong one is found out.
  DistanceBlock measure(const Eigen::Vector3d& first_W, double cell, double most = 1e9) const;

 private:
  const geometry::SurfaceQuery* surface_W_;
  Eigen::Vector3d origin_W_;  // of the triangles' coordinates
  std::vector<BlockTriangle> triangles_;
};

}  // namespace prehend::grasp
