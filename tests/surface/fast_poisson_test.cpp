#include "prehend/surface/fast_poisson.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <vector>

#include <gtest/gtest.h>

#include "tests/surface/manifold.h"
#include "tests/surface/sampled_solid.h"

namespace prehend::surface {
namespace {

using geometry::TriangleMesh;

/// Turned, so that no face lies along the grid.
TriangleMesh turned(const TriangleMesh& mesh) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  return geometry::transformed(mesh, X);
}

struct Solid {
  TriangleMesh mesh;
  double most_at_64;  // mean deviation [m]
  double most_at_128;
};

/// The bounds are what pcl_poisson() reaches at depths 6 and 7 with these points, or less.
std::vector<Solid> solids() {
  return {{turned(geometry::make_sphere(0.05, 128)), 3e-5, 2.5e-5},
          {turned(geometry::make_revolution({{0.04, 0}, {0.04, 0.1}}, 128)), 4.5e-5, 2.5e-5},
          {turned(geometry::make_box({0.06, 0.08, 0.1})), 5e-5, 3e-5}};
}

TEST(FastPoisson, IsAsNearToSolidsAsThePclOneAndAManifold) {
  for (const Solid& solid : solids()) {
    const geometry::PointCloud cloud = sampled(solid.mesh, 40000);
    for (const int resolution : {64, 128}) {
      const auto mesh = fast_poisson(cloud, std::nullopt, {.resolution = resolution}).mesh;
      ASSERT_NO_FATAL_FAILURE(expect_manifold(mesh));
      const MeshDeviation d = mesh_deviation(mesh, solid.mesh);
      const double most = resolution == 64 ? solid.most_at_64 : solid.most_at_128;
      EXPECT_LT(d.to_second.mean, most) << resolution;
      EXPECT_LT(d.from_second.mean, 1.5 * most) << resolution;
      EXPECT_NEAR(geometry::mass_properties(mesh).volume,
                  geometry::mass_properties(solid.mesh).volume,
                  2e-3 * geometry::mass_properties(solid.mesh).volume);
    }
  }
}

TEST(FastPoisson, DensityMayVaryAHundredfold) {
  // One half of each solid has a hundredth of the other's points, as a mirrored view may have.
  for (const Solid& solid : solids()) {
    const geometry::PointCloud dense = sampled(solid.mesh, 40000);
    geometry::PointCloud cloud;
    int kept = 0;
    for (std::size_t i = 0; i < dense.size(); ++i) {
      if (dense.points[i].x() > 0 && ++kept % 100 != 0) continue;
      cloud.points.push_back(dense.points[i]);
      cloud.normals.push_back(dense.normals[i]);
    }
    const auto mesh = fast_poisson(cloud, std::nullopt).mesh;
    ASSERT_NO_FATAL_FAILURE(expect_manifold(mesh));
    const MeshDeviation d = mesh_deviation(mesh, solid.mesh);
    // 200 points on half a solid are 8 mm apart.
    EXPECT_LT(d.to_second.mean, 7e-4);
    EXPECT_LT(d.from_second.mean, 7e-4);
    EXPECT_LT(d.to_second.max, 6e-3);
    EXPECT_NEAR(geometry::mass_properties(mesh).volume,
                geometry::mass_properties(solid.mesh).volume,
                0.02 * geometry::mass_properties(solid.mesh).volume);
  }
}

TEST(FastPoisson, ScreeningSharpensTheEdgesOfABox) {
  const TriangleMesh box = turned(geometry::make_box({0.06, 0.08, 0.1}));
  const geometry::PointCloud cloud = sampled(box, 40000);
  const auto error = [&](double point_weight) {
    const auto mesh =
        fast_poisson(cloud, std::nullopt, {.resolution = 64, .point_weight = point_weight}).mesh;
    return mesh_deviation(mesh, box).from_second.percentile_95;
  };
  EXPECT_LT(error(16), 0.7 * error(0));
}

TEST(FastPoisson, NodesAreNoNearerThanTheLeastSpacing) {
  const Solid ball = solids()[0];
  const geometry::PointCloud cloud = sampled(ball.mesh, 40000);
  const auto triangles = [&](const FastPoissonOptions& options) {
    return fast_poisson(cloud, std::nullopt, options).mesh.triangles.size();
  };
  // 0.05 m of radius, 1.25 times as much for the grid: 62 nodes would be 2 mm apart, 48 are.
  EXPECT_EQ(triangles({.least_spacing = 0.002}), triangles({.resolution = 48}));
  EXPECT_EQ(triangles({.least_spacing = 0.0009}), triangles({}));  // 128 are farther apart
  EXPECT_EQ(triangles({.least_spacing = 1e9}), triangles({.resolution = 32}));
  for (const double bad : {-0.001, std::nan(""), HUGE_VAL}) {
    EXPECT_THROW(triangles({.least_spacing = bad}), std::invalid_argument) << bad;
  }
}

TEST(FastPoisson, OrderOfThePointsDoesNotMatter) {
  const TriangleMesh box = turned(geometry::make_box({0.06, 0.08, 0.1}));
  const geometry::PointCloud cloud = sampled(box, 5000);
  geometry::PointCloud reversed = cloud;
  std::reverse(reversed.points.begin(), reversed.points.end());
  std::reverse(reversed.normals.begin(), reversed.normals.end());
  const auto first = fast_poisson(cloud, std::nullopt).mesh;
  const auto second = fast_poisson(reversed, std::nullopt).mesh;
  EXPECT_EQ(first.vertices, second.vertices);
  EXPECT_EQ(first.triangles, second.triangles);
}

TEST(FastPoisson, NothingIsUnderTheTable) {
  const auto can = geometry::make_revolution({{0.04, -0.02}, {0.04, 0.08}}, 128);
  const auto mesh = fast_poisson(sampled(can, 20000), geometry::Plane{}).mesh;
  ASSERT_NO_FATAL_FAILURE(expect_manifold(mesh));
  EXPECT_NEAR(geometry::bounds(mesh).min().z(), 0, 1e-6);
  EXPECT_NEAR(geometry::mass_properties(mesh).volume, EIGEN_PI * 0.04 * 0.04 * 0.08, 4e-6);
}

/// The upper side of a sheet of 0.1 m x 0.1 m, as high as `height` says.
geometry::PointCloud sheet(const std::function<double(double, double)>& height) {
  geometry::PointCloud cloud;
  for (int i = 0; i < 60; ++i) {
    for (int j = 0; j < 60; ++j) {
      const auto at = [&](double x, double y) { return Eigen::Vector3d(x, y, height(x, y)); };
      const double x = i / 590.0;
      const double y = j / 590.0;
      const Eigen::Vector3d n =
          (at(x + 1e-6, y) - at(x, y)).cross(at(x, y + 1e-6) - at(x, y)).normalized();
      cloud.points.push_back(at(x, y).cast<float>());
      cloud.normals.push_back(n.cast<float>());
    }
  }
  return cloud;
}

TEST(FastPoisson, AnOpenSheetIsOpen) {
  EXPECT_FALSE(fast_poisson(sampled(geometry::make_sphere(0.05), 5000), std::nullopt).is_open);
  EXPECT_TRUE(fast_poisson(sheet([](double, double) { return 0; }), std::nullopt).is_open);
  const auto bowl = sheet(
      [](double x, double y) { return 8 * ((x - 0.05) * (x - 0.05) + (y - 0.05) * (y - 0.05)); });
  EXPECT_TRUE(fast_poisson(bowl, std::nullopt, {.close_by_hull = false}).is_open);
}

TEST(FastPoisson, ABowlSeenFromAboveIsClosedByItsHullAndStaysHollow) {
  const auto height = [](double x, double y) {
    return 8 * ((x - 0.05) * (x - 0.05) + (y - 0.05) * (y - 0.05));
  };
  const geometry::PointCloud cloud = sheet(height);
  const PoissonSurface surface = fast_poisson(cloud, std::nullopt);
  EXPECT_FALSE(surface.is_open);
  EXPECT_TRUE(surface.closed_by_hull);
  ASSERT_NO_FATAL_FAILURE(expect_manifold(surface.mesh));
  const geometry::MeshQuery query(surface.mesh);
  double sum = 0;
  for (const auto& p : cloud.points) sum += query.nearest(p.cast<double>())->distance;
  EXPECT_LT(sum / static_cast<double>(cloud.size()), 5e-4);
  EXPECT_FALSE(query.contains({0.05, 0.05, 0.01}));
  EXPECT_TRUE(query.contains({0.05, 0.05, -0.0005}));  // a shell, a node thick
  EXPECT_GT(geometry::bounds(surface.mesh).min().z(), -0.003);
}

TEST(FastPoisson, DensitiesTrimWhatNoPointSupports) {
  // A ball without its cap: the surface closes over it, the trimmed one does not.
  const geometry::PointCloud whole = sampled(geometry::make_sphere(0.05, 128), 20000);
  geometry::PointCloud cloud;
  for (std::size_t i = 0; i < whole.size(); ++i) {
    if (whole.points[i].z() > 0.035f) continue;
    cloud.points.push_back(whole.points[i]);
    cloud.normals.push_back(whole.normals[i]);
  }
  const PoissonSurface surface = fast_poisson(cloud, std::nullopt, {.vertex_density = true});
  ASSERT_EQ(surface.density.size(), surface.mesh.vertices.size());
  const double density = 20000 / (4 * EIGEN_PI * 0.05 * 0.05);
  std::vector<float> sorted = surface.density;
  std::nth_element(sorted.begin(), sorted.begin() + sorted.size() / 2, sorted.end());
  EXPECT_NEAR(sorted[sorted.size() / 2], density, 0.25 * density);

  const TriangleMesh part = trimmed(surface, 0.4 * density);
  EXPECT_GT(geometry::bounds(surface.mesh).max().z(), 0.037);
  EXPECT_LT(geometry::bounds(part).max().z(), 0.039);
  const geometry::MeshDefects defects = geometry::find_defects(part);
  EXPECT_GT(defects.boundary_edges, 20);
  EXPECT_EQ(defects.non_manifold_edges + defects.degenerate_triangles, 0);
  const double cap = 2 * EIGEN_PI * 0.05 * 0.015;
  EXPECT_NEAR(geometry::surface_area(part), 4 * EIGEN_PI * 0.05 * 0.05 - cap, 0.2 * cap);
  EXPECT_THROW(trimmed(fast_poisson(cloud, std::nullopt), 1), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::surface
