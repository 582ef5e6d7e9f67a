#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/surface/voxel_solid.h"

namespace prehend::surface {

/// Voxels from `low` to `high`, both included.
struct VoxelBox {
  Eigen::Vector3i low;
  Eigen::Vector3i high;
};

/// Boxes that share one hull.
struct BoxPart {
  std::vector<VoxelBox> boxes;
  float concavity = 0;  // greatest distance from the solid of a voxel in the part's hull [voxels]
};

/// The parts of `solid` that convex_pieces() makes pieces of: cut until every concavity is at most
/// `concavity` [voxels] or there are `max_parts`, then joined where the common hull allows it. The
/// hulls are those of the filled voxels' centres.
std::vector<BoxPart> convex_parts(const VoxelSolid& solid, float concavity, int max_parts);

}  // namespace prehend::surface
