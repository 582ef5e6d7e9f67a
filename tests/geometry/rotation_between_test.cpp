#include "prehend/geometry/rotation_between.h"

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::geometry {
namespace {

using Eigen::Vector3d;

TEST(RotationBetween, TakesOneDirectionToTheOtherByTheShortestTurn) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 10000; ++i) {
    const Vector3d from(normal(random), normal(random), normal(random));
    const Vector3d to = 1e-3 * Vector3d(normal(random), normal(random), normal(random));
    const Eigen::Quaterniond R = rotation_between(from, to);
    EXPECT_LT((R * from.normalized() - to.normalized()).norm(), 1e-14);
    const double between = std::atan2(from.cross(to).norm(), from.dot(to));
    EXPECT_NEAR(2 * std::atan2(R.vec().norm(), std::abs(R.w())), between, 1e-13);
  }
}

TEST(RotationBetween, NearlyAndExactlyOppositeDirectionsAreTurnedByHalf) {
  for (const double off : {0.0, 1e-300, 1e-15, 1e-12, 1e-9, 1e-6, 1e-3}) {
    const Vector3d from(1, 2, -0.5);
    const Vector3d to = -from + off * from.unitOrthogonal();
    const Eigen::Quaterniond R = rotation_between(from, to);
    EXPECT_NEAR(R.norm(), 1, 1e-15);
    EXPECT_LT((R * from.normalized() - to.normalized()).norm(), 1e-11) << off;
  }
}

TEST(RotationBetween, LengthsDoNotMatterAndNoDirectionIsRefused) {
  const Eigen::Quaterniond R = rotation_between({1e300, 0, 0}, {0, 1e-300, 0});
  EXPECT_LT((R * Vector3d::UnitX() - Vector3d::UnitY()).norm(), 1e-15);
  EXPECT_THROW(rotation_between({0, 0, 0}, {0, 0, 1}), std::invalid_argument);
  EXPECT_THROW(rotation_between({0, 0, 1}, {0, std::numeric_limits<double>::quiet_NaN(), 1}),
               std::invalid_argument);
}

}  // namespace
}  // namespace prehend::geometry
