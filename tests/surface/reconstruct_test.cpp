#include "prehend/surface/reconstruct.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/surface/sampled_solid.h"

namespace prehend::surface {
namespace {

void expect_close(const geometry::TriangleMesh& mesh, const geometry::TriangleMesh& truth,
                  double mean, double percentile_95) {
  EXPECT_TRUE(geometry::find_defects(mesh).watertight());
  EXPECT_NEAR(geometry::mass_properties(mesh).volume / geometry::mass_properties(truth).volume, 1,
              0.02);
  const MeshDeviation d = mesh_deviation(mesh, truth);
  EXPECT_LT(d.to_second.mean, mean);
  EXPECT_LT(d.from_second.mean, mean);
  EXPECT_LT(d.to_second.percentile_95, percentile_95);
  EXPECT_LT(d.from_second.percentile_95, percentile_95);
}

TEST(Reconstruct, SphereWithinATenthOfAMillimetre) {
  const auto truth = geometry::make_sphere(0.05, 128);
  const auto mesh = reconstruct(sampled(truth, 15000), std::nullopt);
  expect_close(mesh, truth, 1e-4, 2e-4);
  EXPECT_LT(mesh_deviation(mesh, truth).to_second.max, 1e-3);
}

TEST(Reconstruct, CylinderWithinAMillimetre) {
  const auto truth = geometry::make_revolution({{0.04, 0}, {0.04, 0.1}}, 128);
  const auto mesh = reconstruct(sampled(truth, 15000), std::nullopt);
  expect_close(mesh, truth, 3e-4, 1e-3);
}

TEST(Reconstruct, BoxWithinAMillimetre) {
  const auto truth = geometry::make_box({0.06, 0.08, 0.1});
  const auto mesh = reconstruct(sampled(truth, 15000), std::nullopt);
  expect_close(mesh, truth, 3e-4, 1e-3);
}

TEST(Reconstruct, WorksFarFromTheOriginAndAtAnySize) {
  for (const double size : {0.001, 100.0}) {
    const auto truth =
        shifted(geometry::make_sphere(size, 128), Eigen::Vector3d::Constant(20 * size));
    const auto mesh = reconstruct(sampled(truth, 8000), std::nullopt);
    expect_close(mesh, truth, 3e-3 * size, 1e-2 * size);
  }
}

TEST(Reconstruct, DropsCrumbs) {
  auto cloud = sampled(geometry::make_sphere(0.05, 64), 10000);
  const auto crumb = sampled(shifted(geometry::make_sphere(0.004, 64), {0.09, 0, 0}), 300);
  cloud.points.insert(cloud.points.end(), crumb.points.begin(), crumb.points.end());
  cloud.normals.insert(cloud.normals.end(), crumb.normals.begin(), crumb.normals.end());
  const auto mesh = reconstruct(cloud, std::nullopt);
  EXPECT_LT(geometry::bounds(mesh).max().x(), 0.06);
}

TEST(Reconstruct, SameInputGivesTheSameBits) {
  const auto cloud = sampled(geometry::make_sphere(0.05, 64), 5000);
  const auto first = reconstruct(cloud, std::nullopt);
  const auto second = reconstruct(cloud, std::nullopt);
  EXPECT_EQ(first.vertices, second.vertices);
  EXPECT_EQ(first.triangles, second.triangles);
}

TEST(Reconstruct, NothingLiesBelowTheTable) {
  // Without its bottom the surface of a can would bulge through the table.
  auto cloud = sampled(geometry::make_revolution({{0.04, 0}, {0.04, 0.1}}, 128), 15000);
  geometry::PointCloud open;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (cloud.points[i].z() < 0.01f) continue;
    open.points.push_back(cloud.points[i]);
    open.normals.push_back(cloud.normals[i]);
  }
  const auto mesh = reconstruct(open, geometry::Plane{});
  expect_close(mesh, geometry::make_revolution({{0.04, 0}, {0.04, 0.1}}, 128), 5e-4, 1.5e-3);
  EXPECT_GE(geometry::bounds(mesh).min().z(), -1e-9);
  EXPECT_LT(geometry::bounds(mesh).min().z(), 1e-3);
}

TEST(Reconstruct, SaysWhyThereIsNoMesh) {
  // One open sheet encloses nothing.
  geometry::PointCloud sheet;
  for (int i = 0; i < 400; ++i) {
    sheet.points.emplace_back(0.005f * (i % 20), 0.005f * (i / 20), 0.f);
    sheet.normals.emplace_back(0.f, 0.f, 1.f);
  }
  try {
    reconstruct(sheet, std::nullopt);
    FAIL() << "an open sheet gave a watertight mesh";
  } catch (const geometry::InputError& error) {
    const std::string text = error.what();
    EXPECT_NE(text.find("no watertight mesh"), std::string::npos) << text;
    EXPECT_NE(text.find("open"), std::string::npos) << text;
  }
}

TEST(Reconstruct, HostileInputIsRefused) {
  EXPECT_THROW(reconstruct({}, std::nullopt), geometry::InputError);
  auto cloud = sampled(geometry::make_sphere(0.05), 1000);
  auto without_normals = cloud;
  without_normals.normals.clear();
  EXPECT_THROW(reconstruct(without_normals, std::nullopt), geometry::InputError);
  auto with_nan = cloud;
  with_nan.points[7].x() = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(reconstruct(with_nan, std::nullopt), geometry::InputError);
  auto coincident = cloud;
  for (auto& p : coincident.points) p.setZero();
  EXPECT_THROW(reconstruct(coincident, std::nullopt), geometry::InputError);
  const auto refuses = [&](auto change) {
    SurfaceOptions options;
    change(options);
    EXPECT_THROW(reconstruct(cloud, std::nullopt, options), std::invalid_argument);
  };
  for (const int depth : {2, 11}) {
    refuses([&](SurfaceOptions& o) {
      o.method = SurfaceMethod::kPclPoisson;
      o.pcl_poisson.depth = depth;
    });
  }
  refuses([](SurfaceOptions& o) {
    o.method = SurfaceMethod::kPclPoisson;
    o.pcl_poisson.scale = 1;
  });
  for (const int resolution : {0, 31, 100, 272, 1 << 30}) {
    refuses([&](SurfaceOptions& o) { o.fast_poisson.resolution = resolution; });
  }
  refuses([](SurfaceOptions& o) { o.fast_poisson.scale = 1; });
  refuses([](SurfaceOptions& o) { o.fast_poisson.point_weight = -1; });
  refuses([](SurfaceOptions& o) { o.fast_poisson.point_weight = NAN; });
  refuses([](SurfaceOptions& o) { o.fast_poisson.screening_iterations = -1; });
  refuses([](SurfaceOptions& o) { o.fast_poisson.spread = 0; });
  refuses([](SurfaceOptions& o) { o.footprint_slice = 0; });
}

// Between two neighbours and on the table: no vertex is pushed out of one by the other.
TEST(Reconstruct, NothingIsUnderSeveralBounds) {
  const geometry::PointCloud cloud = sampled(geometry::make_sphere(0.05, 64), 10000);
  const std::vector<geometry::Plane> bounds = {{Eigen::Vector3d(1, 0.6, 0).normalized(), -0.02},
                                               {Eigen::Vector3d(-1, 0.6, 0).normalized(), -0.02}};
  const geometry::Plane table{Eigen::Vector3d(0, -0.5, 1).normalized(), -0.03};
  for (const SurfaceMethod method : {SurfaceMethod::kFastPoisson, SurfaceMethod::kPclPoisson}) {
    SurfaceOptions options;
    options.method = method;
    options.close_bottom = false;
    options.pcl_poisson.depth = 6;
    const auto mesh = reconstruct(cloud, table, options, {}, bounds);
    EXPECT_TRUE(geometry::find_defects(mesh).watertight());
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      EXPECT_GE(table.signed_distance(vertex), -1e-6);
      for (const auto& bound : bounds) EXPECT_GE(bound.signed_distance(vertex), -1e-6);
    }
  }
}

// A ball of which 2 cm of 5 are a neighbour's, by either method.
TEST(Reconstruct, NothingIsUnderABound) {
  const double radius = 0.05, height = 0.03;
  const geometry::PointCloud cloud = sampled(geometry::make_sphere(radius, 64), 20000);
  const Eigen::Vector3d normal = Eigen::Vector3d(1, 2, -2).normalized();
  const std::vector<geometry::Plane> bounds = {{normal, -height}};
  for (const SurfaceMethod method : {SurfaceMethod::kFastPoisson, SurfaceMethod::kPclPoisson}) {
    SurfaceOptions options;
    options.method = method;
    options.pcl_poisson.depth = 6;
    const auto mesh = reconstruct(cloud, std::nullopt, options, {}, bounds);
    EXPECT_TRUE(geometry::find_defects(mesh).watertight());
    for (const Eigen::Vector3d& vertex : mesh.vertices) {
      EXPECT_GE(bounds[0].signed_distance(vertex), -1e-9);
    }
    // The ball without its cap, of height h.
    const double h = radius - height;
    const double volume =
        std::numbers::pi * (4. / 3 * std::pow(radius, 3) - h * h * (radius - h / 3));
    EXPECT_NEAR(geometry::mass_properties(mesh).volume, volume, 0.02 * volume);
  }
}

}  // namespace
}  // namespace prehend::surface
