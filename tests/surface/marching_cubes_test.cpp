#include "prehend/surface/marching_cubes.h"

#include <cmath>
#include <limits>
#include <random>

#include <gtest/gtest.h>

#include "prehend/geometry/triangle_mesh.h"
#include "tests/surface/manifold.h"

namespace prehend::surface {
namespace {

using geometry::TriangleMesh;

ScalarGrid noise(const Eigen::Vector3i& size, std::mt19937& random) {
  ScalarGrid grid(size);
  grid.fill(0);
  for (int z = 0; z < size.z(); ++z) {
    for (int y = 0; y < size.y(); ++y) {
      for (int x = 0; x < size.x(); ++x) {
        grid.at(x, y, z) = static_cast<float>(random() % 2001) / 1000 - 1;
      }
    }
  }
  return grid;
}

TEST(MarchingCubes, GiveAManifoldForAThousandFieldsOfNoise) {
  for (unsigned seed = 0; seed < 1000; ++seed) {
    std::mt19937 random(seed);
    const Eigen::Vector3i size(4 + random() % 6, 4 + random() % 6, 4 + random() % 6);
    const TriangleMesh mesh = marching_cubes(noise(size, random), 0);
    ASSERT_FALSE(mesh.empty());
    ASSERT_NO_FATAL_FAILURE(expect_manifold(mesh)) << "seed " << seed;
  }
}

TEST(MarchingCubes, GiveAManifoldForEverySetOfCorners) {
  // Every pattern of one cube, and of two cubes side by side whose common face is ambiguous or not.
  for (int pattern = 0; pattern < 4096; ++pattern) {
    ScalarGrid grid({5, 4, 4});
    grid.fill(-1);
    for (int corner = 0; corner < 12; ++corner) {
      if (pattern >> corner & 1) {
        grid.at(1 + corner % 3, 1 + corner / 3 % 2, 1 + corner / 6) = 1;
      }
    }
    ASSERT_NO_FATAL_FAILURE(expect_manifold(marching_cubes(grid, 0))) << "pattern " << pattern;
  }
}

TEST(MarchingCubes, KeepNodesAtTheLevelAndNumbersThatAreNoneInOrder) {
  const float values[] = {0,
                          1,
                          -1,
                          std::numeric_limits<float>::quiet_NaN(),
                          std::numeric_limits<float>::infinity(),
                          -std::numeric_limits<float>::infinity(),
                          1e-42f,
                          3e38f};
  for (unsigned seed = 0; seed < 300; ++seed) {
    std::mt19937 random(seed);
    ScalarGrid grid({6, 7, 6});
    for (std::size_t i = 0; i < grid.count(); ++i) grid.data()[i] = values[random() % 8];
    const TriangleMesh mesh = marching_cubes(grid, 0);
    ASSERT_NO_FATAL_FAILURE(expect_manifold(mesh)) << "seed " << seed;
    for (const Eigen::Vector3d& vertex : mesh.vertices) ASSERT_TRUE(vertex.allFinite());
  }
}

TEST(MarchingCubes, TakeTheBorderForOutside) {
  ScalarGrid grid({9, 8, 7});
  grid.fill(1);
  const TriangleMesh mesh = marching_cubes(grid, 0);
  ASSERT_NO_FATAL_FAILURE(expect_manifold(mesh));
  EXPECT_GE(geometry::bounds(mesh).min().minCoeff(), 0);
  EXPECT_GT(geometry::mass_properties(mesh).volume, 6 * 5 * 4);
  EXPECT_TRUE(marching_cubes(grid, 1).empty());
  EXPECT_TRUE(marching_cubes(ScalarGrid({1, 1, 1}), 0).empty());
}

TEST(MarchingCubes, FindABallFromItsDistance) {
  // One voxel row is longer than the eight nodes that are skipped at once.
  const double radius = 12.3;
  ScalarGrid grid({40, 33, 36});
  grid.fill(0);
  const Eigen::Vector3d center(19.4, 16.2, 17.7);
  for (int z = 0; z < 36; ++z) {
    for (int y = 0; y < 33; ++y) {
      for (int x = 0; x < 40; ++x) {
        grid.at(x, y, z) = static_cast<float>(radius - (Eigen::Vector3d(x, y, z) - center).norm());
      }
    }
  }
  const TriangleMesh mesh = marching_cubes(grid, 0);
  ASSERT_NO_FATAL_FAILURE(expect_manifold(mesh));
  const double volume = 4.0 / 3 * EIGEN_PI * radius * radius * radius;
  EXPECT_NEAR(geometry::mass_properties(mesh).volume, volume, 0.01 * volume);
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    ASSERT_NEAR((vertex - center).norm(), radius, 0.03);
  }
}

}  // namespace
}  // namespace prehend::surface
