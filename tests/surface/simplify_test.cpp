// Fewer triangles, and sizes over the table, against closed forms.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <utility>
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

// Of the points of a triangle from the origin.
double least_distance(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                      const Eigen::Vector3d& c) {
  const geometry::MeshQuery triangle({{a, b, c}, {{0, 1, 2}}});
  return triangle.nearest(Eigen::Vector3d::Zero())->distance;
}

// Its vertices are on the ball, its triangles' middles are within it: the error is known.
TEST(Simplified, ABallStaysClosedAndItsErrorIsThatOfTheClosedForm) {
  const TriangleMesh fine = ball(0.05, 6);
  ASSERT_GT(fine.triangles.size(), 80'000u);
  const SimplifiedMesh fewer = simplified(fine, 4'000);
  EXPECT_NEAR(static_cast<double>(fewer.mesh.triangles.size()), 4'000, 100);
  EXPECT_TRUE(geometry::find_defects(fewer.mesh).watertight())
      << geometry::find_defects(fewer.mesh).to_string();
  double deepest = 0;
  for (const Eigen::Vector3i& t : fewer.mesh.triangles) {
    const auto& v = fewer.mesh.vertices;
    deepest = std::max(deepest, 0.05 - least_distance(v[t.x()], v[t.y()], v[t.z()]));
  }
  EXPECT_LE(fewer.error, 1.001 * deepest);
  EXPECT_GT(fewer.error, 0.9 * deepest);
  EXPECT_NEAR(geometry::mass_properties(fewer.mesh).volume, 4. / 3 * std::numbers::pi * 1.25e-4,
              3e-6);
}

// Twelve triangles are the whole of a box, as many as it is cut into.
TEST(Simplified, ABoxLosesNothing) {
  TriangleMesh fine;
  const TriangleMesh box = geometry::make_box({0.1, 0.05, 0.02});
  constexpr int kCuts = 24;  // of each edge
  for (const Eigen::Vector3i& t : box.triangles) {
    const Eigen::Vector3d& a = box.vertices[t.x()];
    const Eigen::Vector3d ab = (box.vertices[t.y()] - a) / kCuts;
    const Eigen::Vector3d ac = (box.vertices[t.z()] - a) / kCuts;
    const auto add = [&](int i, int j, int k, int l, int m, int n) {
      const int first = static_cast<int>(fine.vertices.size());
      for (const auto& [u, w] : {std::pair{i, j}, {k, l}, {m, n}}) {
        fine.vertices.emplace_back(a + u * ab + w * ac);
      }
      fine.triangles.emplace_back(first, first + 1, first + 2);
    };
    for (int i = 0; i < kCuts; ++i) {
      for (int j = 0; i + j < kCuts; ++j) {
        add(i, j, i + 1, j, i, j + 1);
        if (i + j + 1 < kCuts) add(i + 1, j, i + 1, j + 1, i, j + 1);
      }
    }
  }
  const SimplifiedMesh fewer = simplified(fine, 100);
  EXPECT_LE(fewer.mesh.triangles.size(), 100u);
  EXPECT_TRUE(geometry::find_defects(fewer.mesh).watertight());
  EXPECT_LT(fewer.error, 1e-7);
  EXPECT_NEAR(geometry::mass_properties(fewer.mesh).volume, 1e-4, 1e-9);
}

// Collapsed edges pinched such bodies, so that all of their millions of triangles were worked on.
TEST(Simplified, AFinelyWrinkledBodyStaysClosed) {
  constexpr int kAround = 400, kRings = 400;
  TriangleMesh body = geometry::make_revolution(
      [] {
        std::vector<Eigen::Vector2d> profile;
        for (int k = 0; k <= kRings; ++k) {
          const double t = std::numbers::pi * k / kRings;
          profile.emplace_back(0.03 * std::sqrt(std::sin(t)), 0.1 - 0.1 * std::cos(t));
        }
        profile.front().x() = profile.back().x() = 0;
        return profile;
      }(),
      kAround);
  for (Eigen::Vector3d& p : body.vertices) {
    const double turn = std::atan2(p.y(), p.x());
    p.head<2>() *= 1 + 0.004 * std::sin(40 * turn) * std::sin(400 * p.z()) +
                   0.001 * std::sin(100 * turn) * std::sin(1500 * p.z());
  }
  const SimplifiedMesh fewer = simplified(body, 8'000);
  EXPECT_LE(fewer.mesh.triangles.size(), 9'000u);
  EXPECT_TRUE(geometry::find_defects(fewer.mesh).watertight())
      << geometry::find_defects(fewer.mesh).to_string();
  EXPECT_LT(fewer.error, 0.001);
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
