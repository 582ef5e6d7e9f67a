// Fewer triangles, and sizes over the table, against closed forms.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/deviation.h"
#include "prehend/surface/simplify.h"
#include "prehend/surface/size_on_table.h"

namespace prehend::surface {
namespace {

using geometry::TriangleMesh;

// A ball of rows x 2 rows quadrilaterals.
TriangleMesh ball(double radius, int rows) {
  TriangleMesh mesh;
  const int columns = 2 * rows;
  const auto at = [&](int row, int column) {
    const double polar = std::numbers::pi * row / rows;
    const double turn = 2 * std::numbers::pi * column / columns;
    return Eigen::Vector3d(radius * std::sin(polar) * std::cos(turn),
                           radius * std::sin(polar) * std::sin(turn), radius * std::cos(polar));
  };
  // Every triangle with vertices of its own, as STL files have them.
  const auto add = [&](const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                       const Eigen::Vector3d& c) {
    const int n = static_cast<int>(mesh.vertices.size());
    mesh.vertices.insert(mesh.vertices.end(), {a, b, c});
    mesh.triangles.emplace_back(n, n + 1, n + 2);
  };
  for (int row = 0; row < rows; ++row) {
    for (int column = 0; column < columns; ++column) {
      const int next = (column + 1) % columns;
      const Eigen::Vector3d top = row == 0 ? Eigen::Vector3d(0, 0, radius) : at(row, column);
      const Eigen::Vector3d low =
          row + 1 == rows ? Eigen::Vector3d(0, 0, -radius) : at(row + 1, column);
      if (row > 0) add(top, low, at(row, next));
      if (row + 1 < rows) add(low, at(row + 1, next), row == 0 ? top : at(row, next));
    }
  }
  return mesh;
}

TEST(Simplified, ABallStaysClosedAndWithinWhatIsStated) {
  const TriangleMesh fine = ball(0.05, 200);
  ASSERT_GT(fine.triangles.size(), 150'000u);
  const SimplifiedMesh fewer = simplified(fine, 4'000);
  EXPECT_LE(fewer.mesh.triangles.size(), 4'000u);
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
              1e-6);
}

TEST(Simplified, AFewTrianglesStayAsTheyAre) {
  const TriangleMesh box = geometry::make_box({0.1, 0.05, 0.02});
  const SimplifiedMesh same = simplified(box, 1'000);
  EXPECT_EQ(same.mesh.triangles.size(), box.triangles.size());
  EXPECT_EQ(same.error, 0);
}

TEST(Simplified, SameInputSameOutput) {
  const TriangleMesh fine = ball(0.05, 50);
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
