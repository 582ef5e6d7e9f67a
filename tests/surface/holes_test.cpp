#include "prehend/surface/holes.h"

#include <algorithm>

#include <gtest/gtest.h>

namespace prehend::surface {
namespace {

using geometry::TriangleMesh;

// Without the triangles whose centre lies within `radius` [m] of `point`.
TriangleMesh with_hole(TriangleMesh mesh, const Eigen::Vector3d& point, double radius) {
  std::erase_if(mesh.triangles, [&](const Eigen::Vector3i& t) {
    const Eigen::Vector3d center =
        (mesh.vertices[t[0]] + mesh.vertices[t[1]] + mesh.vertices[t[2]]) / 3;
    return (center - point).norm() < radius;
  });
  return mesh;
}

TEST(CloseHoles, MakesASphereWithTwoHolesWatertightAgain) {
  const TriangleMesh sphere = geometry::make_sphere(0.05, 64);
  TriangleMesh mesh = with_hole(with_hole(sphere, {0.05, 0, 0}, 0.01), {-0.05, 0, 0}, 0.006);
  ASSERT_FALSE(geometry::find_defects(mesh).watertight());
  const ClosedHoles closed = close_holes(mesh);
  EXPECT_EQ(closed.holes, 2);
  EXPECT_TRUE(geometry::find_defects(mesh).watertight())
      << geometry::find_defects(mesh).to_string();
  const double volume = geometry::mass_properties(sphere).volume;
  EXPECT_NEAR(geometry::mass_properties(mesh).volume, volume, 0.01 * volume);
  // Discs of the holes' radii.
  EXPECT_NEAR(closed.area, EIGEN_PI * (0.01 * 0.01 + 0.006 * 0.006), 0.3 * closed.area);
}

TEST(CloseHoles, ClosesASingleMissingTriangleWithoutANewVertex) {
  TriangleMesh mesh = geometry::make_box({1, 2, 3});
  mesh.triangles.erase(mesh.triangles.begin() + 4);
  EXPECT_EQ(close_holes(mesh).holes, 1);
  EXPECT_EQ(mesh.vertices.size(), 8u);
  EXPECT_TRUE(geometry::find_defects(mesh).watertight());
  EXPECT_NEAR(geometry::mass_properties(mesh).volume, 6, 1e-12);
}

TEST(CloseHoles, LeavesAClosedAndAnEmptyMeshAlone) {
  TriangleMesh box = geometry::make_box({1, 1, 1}), empty;
  EXPECT_EQ(close_holes(box).holes, 0);
  EXPECT_EQ(close_holes(empty).holes, 0);
  EXPECT_EQ(box.triangles.size(), 12u);
}

TEST(CloseHoles, LeavesHolesThatMeetInAVertexOpen) {
  // Two missing triangles of a sphere that share one vertex only.
  TriangleMesh mesh = geometry::make_sphere(1, 16);
  const int vertex = mesh.triangles[100][0];
  std::vector<std::size_t> around;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    if ((mesh.triangles[i].array() == vertex).any()) around.push_back(i);
  }
  ASSERT_GE(around.size(), 4u);
  const auto shared = [&](std::size_t a, std::size_t b) {
    int count = 0;
    for (int k = 0; k < 3; ++k) {
      count += (mesh.triangles[a].array() == mesh.triangles[b][k]).any();
    }
    return count;
  };
  std::size_t other = 0;
  for (std::size_t i = 1; i < around.size() && other == 0; ++i) {
    if (shared(around[0], around[i]) == 1) other = around[i];
  }
  ASSERT_NE(other, 0u);
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(other));
  mesh.triangles.erase(mesh.triangles.begin() + static_cast<std::ptrdiff_t>(around[0]));
  EXPECT_EQ(close_holes(mesh).holes, 0);
  EXPECT_FALSE(geometry::find_defects(mesh).watertight());
}

}  // namespace
}  // namespace prehend::surface
