#include "prehend/surface/normals.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "tests/surface/sampled_solid.h"

namespace prehend::surface {
namespace {

TEST(Normals, OfASphereAreRadial) {
  const geometry::PointCloud cloud = sampled(geometry::make_sphere(0.05, 128), 8000);
  // Seen from everywhere: each point from a viewpoint outside of it.
  std::vector<Eigen::Vector3d> viewpoints;
  for (const auto& p : cloud.points) viewpoints.push_back(10 * p.cast<double>());
  const auto normals = estimate_normals(cloud.points, viewpoints);
  for (std::size_t i = 0; i < normals.size(); ++i) {
    EXPECT_NEAR(normals[i].norm(), 1, 1e-5);
    EXPECT_GT(normals[i].dot(cloud.points[i].normalized()), std::cos(0.06));
  }
}

TEST(Normals, PointTowardsTheirViewpoint) {
  std::vector<Eigen::Vector3f> points;
  for (int i = 0; i < 100; ++i) points.emplace_back(0.01f * (i % 10), 0.01f * (i / 10), 0.5f);
  for (const double side : {-1.0, 1.0}) {
    const std::vector<Eigen::Vector3d> viewpoints(points.size(), {0, 0, 0.5 + side});
    for (const auto& n : estimate_normals(points, viewpoints)) EXPECT_NEAR(n.z(), side, 1e-5);
  }
}

TEST(Normals, OfMirroredPointsPointTowardsTheMirroredViewpoint) {
  // Two walls, x = -0.05 seen from x = -1 and its mirror image x = 0.05.
  shape::CompletedShape shape;
  for (const auto origin : {shape::PointOrigin::kSeen, shape::PointOrigin::kMirrored}) {
    const float x = origin == shape::PointOrigin::kSeen ? -0.05f : 0.05f;
    for (int i = 0; i < 400; ++i) {
      shape.cloud_W.points.emplace_back(x, 0.005f * (i % 20), 0.005f * (i / 20));
      shape.origin.push_back(origin);
    }
  }
  shape.viewpoint_W = {-1, 0, 0};
  shape.mirrored_viewpoint_W = {1, 0, 0};
  const geometry::PointCloud cloud = oriented_cloud(shape);
  ASSERT_GT(cloud.size(), 500u);
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    EXPECT_NEAR(cloud.normals[i].x(), cloud.points[i].x() < 0 ? -1 : 1, 1e-3);
  }
}

TEST(Outliers, FarPointsGoAndTheRestStays) {
  std::vector<Eigen::Vector3f> points = sampled(geometry::make_sphere(0.05), 3000).points;
  points.emplace_back(0.1f, 0.f, 0.f);
  points.emplace_back(0.f, -0.2f, 0.f);
  const std::vector<int> kept = without_outliers(points);
  EXPECT_TRUE(std::is_sorted(kept.begin(), kept.end()));
  EXPECT_GT(kept.size(), 2950u);
  EXPECT_TRUE(std::none_of(kept.begin(), kept.end(), [](int i) { return i >= 3000; }));
}

TEST(Outliers, FewerPointsThanNeighborsAreAllKept) {
  EXPECT_EQ(without_outliers({{0, 0, 0}, {1, 0, 0}}).size(), 2u);
  EXPECT_TRUE(without_outliers({}).empty());
}

TEST(Normals, HostileInputIsRefused) {
  const std::vector<Eigen::Vector3f> one{{0, 0, 0}};
  EXPECT_THROW(estimate_normals(one, {Eigen::Vector3d::Zero()}), geometry::InputError);
  EXPECT_THROW(estimate_normals(one, {}), std::invalid_argument);
  std::vector<Eigen::Vector3f> points(50, Eigen::Vector3f::Zero());
  points[3].x() = std::numeric_limits<float>::quiet_NaN();
  const std::vector<Eigen::Vector3d> viewpoints(50, Eigen::Vector3d::UnitX());
  EXPECT_THROW(estimate_normals(points, viewpoints), geometry::InputError);
  EXPECT_THROW(without_outliers(points), geometry::InputError);
  EXPECT_THROW(oriented_cloud(shape::CompletedShape()), geometry::InputError);
  shape::CompletedShape coincident;
  coincident.cloud_W.points.assign(50, Eigen::Vector3f::Zero());
  coincident.origin.assign(50, shape::PointOrigin::kSeen);
  EXPECT_THROW(oriented_cloud(coincident), geometry::InputError);
}

TEST(Normals, OfCoincidentPointsAreUnitVectors) {
  const std::vector<Eigen::Vector3f> points(50, Eigen::Vector3f::Ones());
  for (const auto& n : estimate_normals(points, std::vector<Eigen::Vector3d>(50, {0, 0, 0}))) {
    EXPECT_NEAR(n.norm(), 1, 1e-5);
  }
}

}  // namespace
}  // namespace prehend::surface
