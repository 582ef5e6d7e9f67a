#include "prehend/geometry/triangle_mesh.h"

#include <limits>
#include <numbers>
#include <random>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {
namespace {

constexpr double kPi = std::numbers::pi;

RigidTransform some_pose(double distance) {
  return make_transform(Eigen::Quaterniond(0.3, -0.5, 0.7, 0.1),
                        Eigen::Vector3d(1, -2, 0.5) * distance);
}

TEST(MassProperties, BoxMatchesTheClosedForm) {
  const Eigen::Vector3d size(0.2, 0.3, 0.5);
  const MassProperties m = mass_properties(make_box(size));
  const double volume = size.prod();
  EXPECT_NEAR(m.volume, volume, 1e-15);
  EXPECT_NEAR(m.center_of_mass.norm(), 0, 1e-15);
  EXPECT_NEAR(m.unit_density_inertia(0, 0),
              volume / 12 * (size.y() * size.y() + size.z() * size.z()), 1e-15);
  EXPECT_NEAR(m.unit_density_inertia(0, 1), 0, 1e-15);
}

TEST(MassProperties, AreInvariantToRigidMotionEvenFarAway) {
  const TriangleMesh box = make_box({0.2, 0.3, 0.5});
  const MassProperties at_origin = mass_properties(box);
  const RigidTransform X = some_pose(1e4);
  const MassProperties moved = mass_properties(transformed(box, X));
  EXPECT_NEAR(moved.volume, at_origin.volume, 1e-9 * at_origin.volume);
  EXPECT_NEAR((moved.center_of_mass - X * at_origin.center_of_mass).norm(), 0, 1e-8);
  const Eigen::Matrix3d expected =
      X.linear() * at_origin.unit_density_inertia * X.linear().transpose();
  EXPECT_LT((moved.unit_density_inertia - expected).norm(), 1e-8 * expected.norm());
}

TEST(MassProperties, SphereConvergesToTheClosedForm) {
  const double r = 0.05;
  const MassProperties m = mass_properties(make_sphere(r, 256));
  const double volume = 4.0 / 3 * kPi * r * r * r;
  EXPECT_NEAR(m.volume, volume, 1e-3 * volume);
  EXPECT_NEAR(m.unit_density_inertia(2, 2), 0.4 * volume * r * r, 2e-3 * 0.4 * volume * r * r);
}

TEST(MassProperties, InsideOutMeshHasNegativeVolume) {
  TriangleMesh box = make_box({1, 1, 1});
  for (auto& t : box.triangles) std::swap(t[0], t[1]);
  EXPECT_NEAR(mass_properties(box).volume, -1, 1e-12);
}

TEST(Primitives, AreWatertightAndTurnedOutward) {
  const TriangleMesh can = make_revolution({{0.03, 0}, {0.03, 0.1}}, 48);
  const TriangleMesh cone = make_revolution({{0.03, 0}, {0.0, 0.1}}, 48);
  for (const auto& mesh : {make_box({1, 2, 3}), make_sphere(0.5, 32), can, cone}) {
    EXPECT_TRUE(find_defects(mesh).watertight()) << find_defects(mesh).to_string();
    EXPECT_GT(mass_properties(mesh).volume, 0);
  }
  EXPECT_NEAR(mass_properties(cone).volume, kPi * 0.03 * 0.03 * 0.1 / 3, 1e-6);
  EXPECT_NEAR(surface_area(make_box({1, 2, 3})), 22, 1e-12);
}

TEST(Primitives, RefuseImpossibleSizes) {
  EXPECT_THROW(make_box({1, 0, 1}), std::invalid_argument);
  EXPECT_THROW(make_sphere(std::numeric_limits<double>::quiet_NaN()), std::invalid_argument);
  EXPECT_THROW(make_revolution({{0.1, 0}}), std::invalid_argument);
  EXPECT_THROW(make_revolution({{0.1, 0}, {-0.1, 1}}), std::invalid_argument);
}

TEST(MeshDefects, NamesEveryKind) {
  TriangleMesh open = make_box({1, 1, 1});
  open.triangles.pop_back();
  EXPECT_EQ(find_defects(open).boundary_edges, 3);
  EXPECT_EQ(find_defects(open).to_string(), "3 boundary edges");

  TriangleMesh flipped = make_box({1, 1, 1});
  std::swap(flipped.triangles[0][0], flipped.triangles[0][1]);
  EXPECT_EQ(find_defects(flipped).flipped_edges, 3);

  TriangleMesh doubled = make_box({1, 1, 1});
  doubled.triangles.push_back(doubled.triangles.front());
  EXPECT_EQ(find_defects(doubled).non_manifold_edges, 3);

  TriangleMesh bad = make_box({1, 1, 1});
  bad.triangles.emplace_back(0, 0, 1);
  bad.triangles.emplace_back(0, 1, 99);
  bad.triangles.emplace_back(0, 1, -1);
  EXPECT_EQ(find_defects(bad).degenerate_triangles, 3);
  EXPECT_FALSE(find_defects(bad).watertight());
}

TEST(MergedVertices, ClosesASoupOfTrianglesAlsoAcrossCellBorders) {
  const TriangleMesh box = make_box({0.1, 0.1, 0.1});
  TriangleMesh soup;
  std::mt19937 random(1);
  std::uniform_real_distribution<double> jitter(-4e-7, 4e-7);
  for (const auto& t : box.triangles) {
    for (int k = 0; k < 3; ++k) {
      soup.vertices.push_back(box.vertices[t[k]] +
                              Eigen::Vector3d(jitter(random), jitter(random), jitter(random)));
    }
    const int n = static_cast<int>(soup.vertices.size());
    soup.triangles.emplace_back(n - 3, n - 2, n - 1);
  }
  EXPECT_FALSE(find_defects(soup).watertight());
  const TriangleMesh merged = with_merged_vertices(soup, 2e-6);
  EXPECT_EQ(merged.vertices.size(), 8u);
  EXPECT_TRUE(find_defects(merged).watertight());
  EXPECT_THROW(with_merged_vertices(box, 0), std::invalid_argument);
}

// Partners are found in the cell and beyond its borders, wherever the mesh is.
TEST(MergedVertices, RandomPointsAndTheirCopiesBecomeOne) {
  constexpr double kTolerance = 1e-6;
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-0.05, 0.05), jitter(-0.25, 0.25);
  for (const double far : {0.0, 3.0}) {
    TriangleMesh points;
    for (int i = 0; i < 2000; ++i) {
      const Eigen::Vector3d p(place(random), far + place(random), place(random));
      for (int copy = 0; copy < 3; ++copy) {
        points.vertices.push_back(
            p + kTolerance * Eigen::Vector3d(jitter(random), jitter(random), jitter(random)));
      }
    }
    EXPECT_EQ(with_merged_vertices(points, kTolerance).vertices.size(), 2000u);
    EXPECT_EQ(with_merged_vertices(points, 1e-9 * kTolerance).vertices.size(), 6000u);
  }
}

TEST(ConvexHull, OfABoxWithInnerPointsIsTheBoxAtEveryScale) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> inside(-0.49, 0.49);
  for (const double scale : {1e-3, 1.0, 1e3}) {
    std::vector<Eigen::Vector3d> points = make_box({1, 1, 1}).vertices;
    for (int i = 0; i < 500; ++i) {
      points.emplace_back(inside(random), inside(random), inside(random));
    }
    for (auto& p : points) p = p * scale + Eigen::Vector3d(3, 4, 5) * scale;
    const TriangleMesh hull = convex_hull(points);
    EXPECT_TRUE(find_defects(hull).watertight());
    EXPECT_NEAR(mass_properties(hull).volume, scale * scale * scale, 1e-6 * scale * scale * scale);
  }
}

TEST(ConvexHull, RefusesDegenerateInputWithAReason) {
  const std::vector<Eigen::Vector3d> three = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  EXPECT_THROW(convex_hull({}), InputError);
  EXPECT_THROW(convex_hull(three), InputError);
  EXPECT_THROW(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}}), InputError);
  EXPECT_THROW(convex_hull(std::vector<Eigen::Vector3d>(9, Eigen::Vector3d::Ones())), InputError);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(convex_hull({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, nan}}), InputError);
}

TEST(Concatenated, KeepsBothMeshesApart) {
  const TriangleMesh two = concatenated({make_box({1, 1, 1}), make_sphere(1, 16)});
  EXPECT_TRUE(find_defects(two).watertight());
  EXPECT_EQ(two.vertices.size(), 8u + make_sphere(1, 16).vertices.size());
}

TEST(TriangleMesh, VertexNormalsOfASphereAreRadial) {
  TriangleMesh mesh = make_sphere(0.1, 48);
  const std::vector<Eigen::Vector3d> normals = vertex_normals(mesh);
  ASSERT_EQ(normals.size(), mesh.vertices.size());
  for (std::size_t i = 0; i < normals.size(); ++i) {
    EXPECT_NEAR(normals[i].norm(), 1, 1e-12);
    EXPECT_GT(normals[i].dot(mesh.vertices[i].normalized()), std::cos(0.05));
  }
  mesh.vertices.emplace_back(1, 2, 3);  // of no triangle
  EXPECT_TRUE(vertex_normals(mesh).back().isZero());
  EXPECT_TRUE(vertex_normals({}).empty());
}

}  // namespace
}  // namespace prehend::geometry
