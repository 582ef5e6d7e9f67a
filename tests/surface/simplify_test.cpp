// Fewer triangles, and sizes over the table, against closed forms.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <vector>

#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/deviation.h"
#include "prehend/surface/simplify.h"
#include "prehend/surface/size_on_table.h"

namespace prehend::surface {
namespace {

using geometry::TriangleMesh;

// An icosahedron whose triangles are cut into four `times` times, on the ball. Every triangle has
// vertices of its own, as STL files have them.
TriangleMesh ball(double radius, int times) {
  const double g = std::numbers::phi;
  std::vector<Eigen::Vector3d> corners;
  for (const double one : {-1.0, 1.0}) {
    for (const double golden : {-g, g}) {
      corners.emplace_back(0, one, golden);
      corners.emplace_back(one, golden, 0);
      corners.emplace_back(golden, 0, one);
    }
  }
  std::vector<std::array<Eigen::Vector3d, 3>> faces;
  const TriangleMesh hull = geometry::convex_hull(corners);
  for (const Eigen::Vector3i& t : hull.triangles) {
    faces.push_back({hull.vertices[t.x()].normalized(), hull.vertices[t.y()].normalized(),
                     hull.vertices[t.z()].normalized()});
  }
  for (int k = 0; k < times; ++k) {
    std::vector<std::array<Eigen::Vector3d, 3>> finer;
    for (const auto& [a, b, c] : faces) {
      const Eigen::Vector3d ab = (a + b).normalized(), bc = (b + c).normalized(),
                            ca = (c + a).normalized();
      for (const auto& face : {std::array{a, ab, ca}, {b, bc, ab}, {c, ca, bc}, {ab, bc, ca}}) {
        finer.push_back(face);
      }
    }
    faces = std::move(finer);
  }
  TriangleMesh mesh;
  for (const auto& face : faces) {
    const int n = static_cast<int>(mesh.vertices.size());
    for (const Eigen::Vector3d& p : face) mesh.vertices.push_back(radius * p);
    mesh.triangles.emplace_back(n, n + 1, n + 2);
  }
  return mesh;
}

TEST(Simplified, ABallStaysClosedAndWithinWhatIsStated) {
  const TriangleMesh fine = ball(0.05, 6);
  ASSERT_GT(fine.triangles.size(), 80'000u);
  const SimplifiedMesh fewer = simplified(fine, 4'000);
  EXPECT_LE(fewer.mesh.triangles.size(), 16'000u);
  EXPECT_GT(fewer.mesh.triangles.size(), 3'000u);
  EXPECT_TRUE(geometry::find_defects(fewer.mesh).watertight())
      << geometry::find_defects(fewer.mesh).to_string();
  EXPECT_GT(fewer.error, 0);
  EXPECT_LT(fewer.error, 2e-4);
  double farthest = 0;
  for (const Eigen::Vector3i& t : fewer.mesh.triangles) {
    const Eigen::Vector3d middle =
        (fewer.mesh.vertices[t.x()] + fewer.mesh.vertices[t.y()] + fewer.mesh.vertices[t.z()]) / 3;
    farthest = std::max(farthest, std::abs(middle.norm() - 0.05));
  }
  EXPECT_LT(farthest, 3 * fewer.error);
  EXPECT_NEAR(geometry::mass_properties(fewer.mesh).volume, 4. / 3 * std::numbers::pi * 1.25e-4,
              3e-6);
}

TEST(Simplified, AFewTrianglesStayAsTheyAre) {
  const TriangleMesh box = geometry::make_box({0.1, 0.05, 0.02});
  const SimplifiedMesh same = simplified(box, 1'000);
  EXPECT_EQ(same.mesh.triangles.size(), box.triangles.size());
  EXPECT_EQ(same.error, 0);
}

TEST(Simplified, SameInputSameOutput) {
  const TriangleMesh fine = ball(0.05, 4);
  EXPECT_EQ(simplified(fine, 500).mesh.vertices, simplified(fine, 500).mesh.vertices);
}

TEST(SizeOnTable, OfABoxHoweverItIsTurned) {
  const TriangleMesh box = geometry::make_box({0.12, 0.05, 0.03});
  for (const double yaw : {0.0, 0.3, 0.785, 1.9}) {
    geometry::RigidTransform X = geometry::RigidTransform::Identity();
    X.linear() = Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ()).matrix();
    TriangleMesh turned = geometry::transformed(box, X);
    double lowest = 1;
    for (const Eigen::Vector3d& p : turned.vertices) lowest = std::min(lowest, p.z());
    const geometry::Plane table{Eigen::Vector3d::UnitZ(), lowest};
    const Eigen::Vector3d size = size_on_table(turned, table);
    EXPECT_LT((size - Eigen::Vector3d(0.12, 0.05, 0.03)).norm(), 1e-9) << yaw;
  }
  EXPECT_EQ(size_text({0.1204, 0.05, 0.0296}), "120 x 50 x 30 mm");
}

}  // namespace
}  // namespace prehend::surface
