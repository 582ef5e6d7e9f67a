#include "eval/solid_overlap.h"

#include <cmath>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval {
namespace {

using Eigen::Vector3d;
using geometry::MeshQuery;

geometry::TriangleMesh overlap_box(const Vector3d& size, const Vector3d& middle) {
  geometry::TriangleMesh mesh = geometry::make_box(size);
  const Vector3d shift = middle - geometry::bounds(mesh).center();
  for (Vector3d& v : mesh.vertices) v += shift;
  return mesh;
}

TEST(JaccardIndex, OfBoxesBesideAndInOneAnother) {
  const MeshQuery box(overlap_box({0.1, 0.1, 0.1}, Vector3d::Zero()));
  EXPECT_EQ(jaccard_index(box, box, 0.005), 1);
  // Shifted by 20 of 100 mm: 80 of 120 mm are in both.
  const MeshQuery shifted(overlap_box({0.1, 0.1, 0.1}, {0.02, 0, 0}));
  EXPECT_NEAR(jaccard_index(box, shifted, 0.005), 80. / 120, 1e-12);
  EXPECT_EQ(jaccard_index(box, shifted, 0.005), jaccard_index(shifted, box, 0.005));
  const MeshQuery half(overlap_box({0.1, 0.1, 0.05}, {0, 0, 0.025}));
  EXPECT_NEAR(jaccard_index(box, half, 0.005), 0.5, 1e-12);
  const MeshQuery apart(overlap_box({0.1, 0.1, 0.1}, {0.2, 0, 0}));
  EXPECT_EQ(jaccard_index(box, apart, 0.005), 0);
}

TEST(JaccardIndex, OfBallsOneInTheOther) {
  const MeshQuery large(geometry::make_sphere(0.05)), small(geometry::make_sphere(0.04));
  EXPECT_NEAR(jaccard_index(large, small, 0.002), std::pow(0.8, 3), 0.005);
}

TEST(JaccardIndex, RefusesVoxelsThatAreNone) {
  const MeshQuery box(overlap_box({0.1, 0.1, 0.1}, Vector3d::Zero()));
  for (const double voxel : {0.0, -0.01, std::nan(""), 1e-5}) {
    EXPECT_THROW(jaccard_index(box, box, voxel), geometry::InputError) << voxel;
  }
}

}  // namespace
}  // namespace prehend::eval
