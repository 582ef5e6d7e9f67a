#include "prehend/surface/closing.h"

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/surface/outline.h"
#include "tests/surface/sampled_solid.h"

namespace prehend::surface {
namespace {

TEST(Outline, OfASquareIsItsCornersCounterClockwise) {
  std::vector<Eigen::Vector2d> points;
  for (int i = 0; i <= 4; ++i) {
    for (int j = 0; j <= 4; ++j) points.emplace_back(i, j);
  }
  std::vector<Eigen::Vector2d> corners;
  for (const int i : convex_outline(points)) corners.push_back(points[i]);
  const std::vector<Eigen::Vector2d> expected{{0, 0}, {4, 0}, {4, 4}, {0, 4}};
  EXPECT_EQ(corners, expected);
  EXPECT_TRUE(contains(corners, {2, 4}));
  EXPECT_FALSE(contains(corners, {2, 4.001}));
}

TEST(Outline, OfPointsOnALineIsEmpty) {
  EXPECT_TRUE(convex_outline({{0, 0}, {1, 1}, {2, 2}, {3, 3}}).empty());
  EXPECT_TRUE(convex_outline({{1, 1}, {1, 1}, {1, 1}}).empty());
  EXPECT_TRUE(convex_outline({}).empty());
}

TEST(CloseBottom, PutsAnUprightSolidsFootprintOnTheTable) {
  const auto solid = shifted(geometry::make_box({0.06, 0.08, 0.1}), {0, 0, 0.05});
  geometry::PointCloud cloud = sampled(solid, 5000);
  const std::size_t count = cloud.size();
  const auto closed = close_bottom(cloud, geometry::Plane{}, 0.2, 0.002);
  double area = 0;
  for (std::size_t i = count; i < closed.size(); ++i) {
    EXPECT_LE(std::abs(closed.points[i].x()), 0.0301f);
    EXPECT_LE(std::abs(closed.points[i].y()), 0.0401f);
    EXPECT_NEAR(closed.points[i].z(), 0, 1e-6);
    EXPECT_NEAR(closed.normals[i].z(), -1, 1e-6);
    area += 0.002 * 0.002;
  }
  EXPECT_NEAR(area, 0.06 * 0.08, 0.06 * 0.08 * 0.1);
}

TEST(CloseBottom, IsNotBetweenTheArmsOfAnAngle) {
  // Two bars at a right angle, tops and sides.
  geometry::PointCloud cloud =
      sampled(shifted(geometry::make_box({0.1, 0.02, 0.03}), {0.05, 0.01, 0.015}), 4000);
  const auto other =
      sampled(shifted(geometry::make_box({0.02, 0.1, 0.03}), {0.01, 0.05, 0.015}), 4000);
  cloud.points.insert(cloud.points.end(), other.points.begin(), other.points.end());
  cloud.normals.insert(cloud.normals.end(), other.normals.begin(), other.normals.end());
  const auto closed = close_bottom(cloud, geometry::Plane{}, 0.2, 0.002);
  int under_bars = 0;
  for (std::size_t i = cloud.size(); i < closed.size(); ++i) {
    const Eigen::Vector3f& p = closed.points[i];
    EXPECT_FALSE(p.x() > 0.03f && p.y() > 0.03f) << p.transpose();
    under_bars += p.z() < 1e-6f;
  }
  EXPECT_GT(under_bars, 0.8 * (0.1 * 0.02 + 0.08 * 0.02) / (0.002 * 0.002));
}

// Front and back of something whose top was not seen: they say nothing of what is between.
TEST(CloseBottom, JoinsTwoSheets) {
  geometry::PointCloud cloud;
  for (double x = -0.05; x <= 0.05; x += 0.002) {
    for (double z = 0.001; z < 0.2; z += 0.002) {
      for (const double side : {-1.0, 1.0}) {
        cloud.points.push_back(Eigen::Vector3d(x, side * 0.04, z).cast<float>());
        cloud.normals.push_back(Eigen::Vector3d(0, side, 0).cast<float>());
      }
    }
  }
  const auto closed = close_bottom(cloud, geometry::Plane{}, 0.2, 0.002);
  double area = 0;
  for (std::size_t i = cloud.size(); i < closed.size(); ++i) {
    area += closed.points[i].z() < 1e-6f ? 0.002 * 0.002 : 0;
  }
  EXPECT_NEAR(area, 0.1 * 0.08, 0.1 * 0.1 * 0.08);
}

TEST(CloseBottom, OfABallIsSmall) {
  // The lowest 10 mm of a ball of 40 mm radius are hidden.
  const auto ball = sampled(shifted(geometry::make_sphere(0.04, 128), {0, 0, 0.04}), 20000);
  geometry::PointCloud cloud;
  for (std::size_t i = 0; i < ball.size(); ++i) {
    if (ball.points[i].z() < 0.01f) continue;
    cloud.points.push_back(ball.points[i]);
    cloud.normals.push_back(ball.normals[i]);
  }
  const auto closed = close_bottom(cloud, geometry::Plane{}, 0.2, 0.001);
  for (std::size_t i = cloud.size(); i < closed.size(); ++i) {
    EXPECT_LT(closed.points[i].head<2>().norm(), 0.005f);
  }
}

TEST(CloseBottom, RefusesACloudUnderItsTable) {
  const auto cloud = sampled(geometry::make_box({0.06, 0.08, 0.1}), 1000);
  EXPECT_THROW(close_bottom(cloud, geometry::Plane{Eigen::Vector3d::UnitZ(), 1}, 0.2, 0.002),
               geometry::InputError);
  EXPECT_THROW(close_bottom({}, geometry::Plane{}, 0.2, 0.002), geometry::InputError);
}

/// A front sheet of `points` and its mirror image at x = 0.
shape::CompletedShape mirrored_sheet(const std::vector<Eigen::Vector3f>& points) {
  shape::CompletedShape shape;
  shape.symmetry.normal_W = Eigen::Vector3d::UnitX();
  for (const float side : {-1.f, 1.f}) {
    for (const auto& p : points) {
      shape.cloud_W.points.emplace_back(side * p.x(), p.y(), p.z());
      shape.origin.push_back(side < 0 ? shape::PointOrigin::kSeen : shape::PointOrigin::kMirrored);
    }
  }
  return shape;
}

TEST(SidePoints, JoinTheFrontOfABoxToItsMirrorImage) {
  std::vector<Eigen::Vector3f> front;
  for (int i = 0; i <= 40; ++i) {
    for (int j = 0; j <= 50; ++j) front.emplace_back(0.03f, -0.04f + 0.002f * i, 0.002f * j);
  }
  const auto sides = side_points(mirrored_sheet(front), geometry::Plane{}, 0.002);
  ASSERT_GT(sides.size(), 1000u);
  for (std::size_t i = 0; i < sides.size(); ++i) {
    EXPECT_NEAR(std::abs(sides.points[i].y()), 0.04, 1e-6);
    EXPECT_LT(std::abs(sides.points[i].x()), 0.03f);
    EXPECT_NEAR(sides.normals[i].y(), sides.points[i].y() < 0 ? -1 : 1, 1e-6);
  }
}

TEST(SidePoints, AddNothingToAClosedRound) {
  std::vector<Eigen::Vector3f> half;
  for (int i = 0; i <= 60; ++i) {
    const float angle = 3.14159265f * (i / 60.f - 0.5f);
    for (int j = 0; j <= 50; ++j) {
      half.emplace_back(0.04f * std::cos(angle), 0.04f * std::sin(angle), 0.002f * j);
    }
  }
  EXPECT_TRUE(side_points(mirrored_sheet(half), geometry::Plane{}, 0.002).empty());
}

}  // namespace
}  // namespace prehend::surface
