// Superquadrics found again from points on their surfaces, and on bodies that some of them are.

#include "eval/superquadric.h"

#include <cmath>
#include <limits>
#include <numbers>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/surface_samples.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/surface/deviation.h"

namespace prehend::eval {
namespace {

using Eigen::Vector3d;

// Barr's parametrisation, over the sphere's longitude and latitude.
std::vector<Vector3d> points_on(const Superquadric& solid) {
  const auto power = [](double x, double e) { return std::copysign(std::pow(std::abs(x), e), x); };
  std::vector<Vector3d> points;
  for (int i = 1; i < 24; ++i) {
    const double latitude = std::numbers::pi * (i / 24.0 - 0.5);
    for (int j = 0; j < 48; ++j) {
      const double longitude = 2 * std::numbers::pi * (j + 0.5) / 48;
      const double ring = power(std::cos(latitude), solid.e1);
      const Vector3d unit(ring * power(std::cos(longitude), solid.e2),
                          ring * power(std::sin(longitude), solid.e2),
                          power(std::sin(latitude), solid.e1));
      points.push_back(solid.X_WS * solid.half_sizes.cwiseProduct(unit));
    }
  }
  return points;
}

std::vector<Vector3d> points_of(const geometry::TriangleMesh& mesh) {
  std::vector<Vector3d> points;
  for (const auto& sample : geometry::surface_samples(mesh, 1000, 1))
    points.push_back(sample.point);
  return points;
}

// [m], mean of the points' distances to the surface of the fit, along rays from its middle.
double mean_off(const Superquadric& fit, const std::vector<Vector3d>& points) {
  double sum = 0;
  for (const Vector3d& p : points) sum += std::abs(fit.radial_distance(p));
  return sum / static_cast<double>(points.size());
}

double volume_of(const Superquadric& fit) {
  const geometry::Plane below{Vector3d::UnitZ(), -1};
  return geometry::mass_properties(mesh_of(fit, below)).volume;
}

TEST(Superquadric, IsFoundAgain) {
  Superquadric truth;
  truth.half_sizes = {0.03, 0.05, 0.09};
  truth.e1 = 0.5;
  truth.e2 = 0.8;
  truth.X_WS.linear() = Eigen::AngleAxisd(0.6, Vector3d(1, 2, 3).normalized()).matrix();
  truth.X_WS.translation() = Vector3d(0.4, -0.2, 0.1);
  const std::vector<Vector3d> points = points_on(truth);
  EXPECT_LT(mean_off(truth, points), 1e-6);
  const Superquadric fit = fit_superquadric(points);
  EXPECT_LT(mean_off(fit, points), 1e-5);
  EXPECT_NEAR(fit.half_sizes.prod(), truth.half_sizes.prod(), 1e-3 * truth.half_sizes.prod());
  EXPECT_NEAR(fit.e1, truth.e1, 0.01);
  EXPECT_NEAR(fit.e2, truth.e2, 0.01);
  EXPECT_LT((fit.X_WS.translation() - truth.X_WS.translation()).norm(), 1e-4);
}

TEST(Superquadric, IsABall) {
  const Superquadric fit = fit_superquadric(points_of(geometry::make_sphere(0.04)));
  for (int k = 0; k < 3; ++k) EXPECT_NEAR(fit.half_sizes[k], 0.04, 5e-4);
  EXPECT_NEAR(fit.e1, 1, 0.03);
  EXPECT_NEAR(fit.e2, 1, 0.03);
  EXPECT_NEAR(volume_of(fit), 4. / 3 * std::numbers::pi * std::pow(0.04, 3), 6e-6);
}

TEST(Superquadric, IsABoxNearly) {
  const std::vector<Vector3d> points = points_of(geometry::make_box({0.06, 0.1, 0.16}));
  const Superquadric fit = fit_superquadric(points);
  EXPECT_LT(fit.e1, 0.3);
  EXPECT_LT(fit.e2, 0.3);
  EXPECT_LT(mean_off(fit, points), 0.0015);
  EXPECT_NEAR(volume_of(fit), 0.06 * 0.1 * 0.16, 0.05 * 0.06 * 0.1 * 0.16);
}

TEST(Superquadric, IsACylinderNearly) {
  std::vector<Vector3d> points;
  for (int i = 0; i < 40; ++i) {
    const double angle = 2 * std::numbers::pi * i / 40;
    const Vector3d rim(0.035 * std::cos(angle), 0.035 * std::sin(angle), 0);
    for (int k = 0; k <= 10; ++k) points.emplace_back(rim + Vector3d(0, 0, 0.012 * k - 0.06));
    for (const double part : {0.3, 0.6, 0.9}) {
      points.emplace_back(part * rim + Vector3d(0, 0, 0.06));
      points.emplace_back(part * rim - Vector3d(0, 0, 0.06));
    }
  }
  const Superquadric fit = fit_superquadric(points);
  EXPECT_LT(fit.e1, 0.3);
  EXPECT_NEAR(fit.e2, 1, 0.1);
  // Its own axis is the cylinder's.
  EXPECT_GT(std::abs(fit.X_WS.linear()(2, 2)), 0.999);
  const double volume = std::numbers::pi * 0.035 * 0.035 * 0.12;
  EXPECT_NEAR(volume_of(fit), volume, 0.05 * volume);
}

TEST(Superquadric, MeshIsOverTheTable) {
  Superquadric ball;
  ball.half_sizes = Vector3d::Constant(0.05);
  const geometry::TriangleMesh mesh = mesh_of(ball, {Vector3d::UnitZ(), 0});
  EXPECT_TRUE(geometry::find_defects(mesh).watertight());
  EXPECT_NEAR(geometry::bounds(mesh).min().z(), 0, 1e-5);
  const double half = 2. / 3 * std::numbers::pi * std::pow(0.05, 3);
  EXPECT_NEAR(geometry::mass_properties(mesh).volume, half, 0.01 * half);
  EXPECT_THROW(mesh_of(ball, {Vector3d::UnitZ(), 0.1}), geometry::InputError);
}

TEST(Superquadric, RefusesWhatItCannotFit) {
  EXPECT_THROW(fit_superquadric({}), geometry::InputError);
  EXPECT_THROW(fit_superquadric(std::vector<Vector3d>(10, Vector3d::UnitX())),
               geometry::InputError);
  EXPECT_THROW(fit_superquadric(std::vector<Vector3d>(20, Vector3d::UnitX())),
               geometry::InputError);
  std::vector<Vector3d> points = points_of(geometry::make_sphere(0.04));
  points[3].x() = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(fit_superquadric(points), geometry::InputError);
}

}  // namespace
}  // namespace prehend::eval
