#include "eval/solid_overlap.h"

#include <cmath>
#include <cstdint>
#include <string>

#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"

namespace prehend::eval {

double jaccard_index(const geometry::MeshQuery& first, const geometry::MeshQuery& second,
                     double voxel) {
  constexpr double kMostVoxels = 1e8;
  Eigen::AlignedBox3d box = first.box();
  box.extend(second.box());
  const Eigen::Array3d count = (box.sizes().array() / voxel).ceil().max(1);
  if (!(voxel > 0) || !(count.prod() <= kMostVoxels)) {
    throw geometry::InputError("Voxels of " + std::to_string(voxel) + " m do not fill a box of " +
                                   std::to_string(box.sizes().maxCoeff()) + " m",
                               "Give a side that is positive and leaves at most 1e8 of them");
  }
  const Eigen::Array3i size = count.cast<int>();
  // In the middle of the box, so that a shift of both solids changes nothing.
  const Eigen::Vector3d low = box.center() - 0.5 * voxel * count.matrix();
  std::int64_t both = 0, either = 0;
  for (int z = 0; z < size.z(); ++z) {
    for (int y = 0; y < size.y(); ++y) {
      for (int x = 0; x < size.x(); ++x) {
        const Eigen::Vector3d p = low + voxel * Eigen::Vector3d(x + 0.5, y + 0.5, z + 0.5);
        const bool in_first = first.contains(p), in_second = second.contains(p);
        both += in_first && in_second;
        either += in_first || in_second;
      }
    }
  }
  return either > 0 ? static_cast<double>(both) / static_cast<double>(either) : 0;
}

}  // namespace prehend::eval
