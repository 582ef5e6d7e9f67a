#pragma once

#include "prehend/geometry/mesh_query.h"

namespace prehend::eval {

/// Jaccard index of two solids: the volume of what both hold over that of what either holds,
/// counted by the middles of cubes of side `voxel` [m] that fill the box of both. 0 when no middle
/// is inside either. O(voxels), with a dozen rays each.
/// @pre the meshes are watertight. @throws geometry::InputError for a voxel that is not positive
/// and for more than 1e8 voxels.
double jaccard_index(const geometry::MeshQuery& first, const geometry::MeshQuery& second,
                     double voxel);

}  // namespace prehend::eval
