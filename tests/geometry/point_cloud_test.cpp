#include "prehend/geometry/point_cloud.h"

#include <limits>

#include <gtest/gtest.h>

namespace prehend::geometry {
namespace {

constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

PointCloud organized_cloud() {
  PointCloud cloud;
  cloud.width = 2;
  cloud.height = 2;
  cloud.points = {{0, 0, 1}, {kNan, kNan, kNan}, {1, 0, kInfinity}, {2, 0, 1}};
  cloud.colors = {{1, 2, 3}, {4, 5, 6}, {7, 8, 9}, {10, 11, 12}};
  return cloud;
}

TEST(PointCloud, WithoutInvalidKeepsColoursWithTheirPoints) {
  const PointCloud valid = without_invalid(organized_cloud());
  ASSERT_EQ(valid.size(), 2u);
  EXPECT_EQ(valid.colors[1], (Rgb{10, 11, 12}));
  EXPECT_FALSE(valid.organized());
}

TEST(PointCloud, CentroidIgnoresInvalidPointsAndIsZeroWithoutAny) {
  EXPECT_TRUE(centroid(organized_cloud()).isApprox(Eigen::Vector3d(1, 0, 1)));
  EXPECT_EQ(centroid(PointCloud{}), Eigen::Vector3d::Zero());
  PointCloud all_nan;
  all_nan.points.assign(5, Eigen::Vector3f::Constant(kNan));
  EXPECT_EQ(centroid(all_nan), Eigen::Vector3d::Zero());
}

TEST(PointCloud, TransformKeepsOrganizationAndTurnsNormalsOnlyByRotation) {
  PointCloud cloud = organized_cloud();
  cloud.normals.assign(4, Eigen::Vector3f::UnitX());
  const RigidTransform X_AB = make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(EIGEN_PI / 2, Eigen::Vector3d::UnitZ())), {5, 0, 0});
  const PointCloud out = transformed(cloud, X_AB);
  EXPECT_TRUE(out.organized());
  EXPECT_TRUE(out.points[0].isApprox(Eigen::Vector3f(5, 0, 1)));
  EXPECT_TRUE(out.normals[0].isApprox(Eigen::Vector3f::UnitY(), 1e-6f));
  EXPECT_FALSE(is_finite(out.points[1]));
}

TEST(PointCloud, CentroidKeepsItsDigitsFarFromTheOrigin) {
  PointCloud cloud;
  for (int i = 0; i < 100000; ++i) cloud.points.emplace_back(10000.0f, 10000.0f, 10000.0f);
  EXPECT_NEAR(centroid(cloud).x(), 10000.0, 1e-9);
}

}  // namespace
}  // namespace prehend::geometry
