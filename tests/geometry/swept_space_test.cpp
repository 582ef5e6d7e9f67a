#include "prehend/geometry/swept_space.h"

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::geometry {
namespace {

const Eigen::AlignedBox3d kBox(Eigen::Vector3d(-0.1, -0.1, 0), Eigen::Vector3d(0.1, 0.1, 0.2));
constexpr double kSpacing = 0.002;

TEST(SweptSpace, NothingIsSweptAtFirst) {
  const SweptSpace space(kBox, kSpacing);
  EXPECT_TRUE(space.empty());
  EXPECT_EQ(space.depth({0, 0, 0.1}), 0);
  EXPECT_EQ(space.size(), Eigen::Vector3i(100, 100, 100));
}

TEST(SweptSpace, IsAsDeepInABallAsTheBallIs) {
  SweptSpace space(kBox, kSpacing);
  const Eigen::Vector3d center(0.01, -0.02, 0.1);
  space.add_ball(center, 0.02);
  EXPECT_FALSE(space.empty());
  std::mt19937 random(1);
  std::uniform_real_distribution<double> offset(-0.04, 0.04);
  for (int i = 0; i < 2000; ++i) {
    const Eigen::Vector3d p =
        center + Eigen::Vector3d(offset(random), offset(random), offset(random));
    const double truth = 0.02 - (p - center).norm();
    // Linear between voxels; the ball's middle is a kink.
    EXPECT_NEAR(space.depth(p), std::max(0.0, truth), 0.6 * kSpacing) << p.transpose();
  }
}

TEST(SweptSpace, APathHasNoGaps) {
  SweptSpace space(kBox, kSpacing);
  const Eigen::Vector3d from(-0.09, 0.01, 0.03), to(0.08, -0.05, 0.17);
  space.add_path(from, to, 0.006);
  for (int i = 0; i <= 1000; ++i) {
    EXPECT_GT(space.depth(from + i / 1000. * (to - from)), 0.004);
  }
  EXPECT_EQ(space.depth(from + Eigen::Vector3d(0, 0.02, 0)), 0);
}

// In any order, and in parts.
TEST(SweptSpace, IsTheUnion) {
  SweptSpace one(kBox, kSpacing), other(kBox, kSpacing), parts(kBox, kSpacing);
  const Eigen::Vector3d a(0, 0, 0.05), b(0.01, 0, 0.06), c(-0.05, 0.05, 0.1);
  for (const auto& p : {a, b, c}) one.add_ball(p, 0.015);
  for (const auto& p : {c, b, a}) other.add_ball(p, 0.015);
  EXPECT_EQ(one.depths(), other.depths());
  SweptSpace part(kBox, kSpacing);
  part.add_ball(a, 0.015);
  parts.add_ball(b, 0.015);
  parts.add_ball(c, 0.015);
  parts.add(part);
  EXPECT_EQ(one.depths(), parts.depths());
}

TEST(SweptSpace, WhatIsBesideTheBoxIsNotKept) {
  SweptSpace space(kBox, kSpacing);
  space.add_ball({0.3, 0, 0.1}, 0.05);
  EXPECT_EQ(space.depth({0.3, 0, 0.1}), 0);
  space.add_ball({0.1, 0, 0.1}, 0.05);  // half of it
  EXPECT_GT(space.depth({0.09, 0, 0.1}), 0.03);
  EXPECT_EQ(space.depth({0.11, 0, 0.1}), 0);
}

TEST(SweptSpace, RefusesWhatItCannotHold) {
  EXPECT_THROW(SweptSpace({}, kSpacing), std::invalid_argument);
  EXPECT_THROW(SweptSpace(kBox, 0), std::invalid_argument);
  EXPECT_THROW(SweptSpace(kBox, std::nan("")), std::invalid_argument);
  EXPECT_THROW(SweptSpace(kBox, 1e-6), std::invalid_argument);
  SweptSpace space(kBox, kSpacing);
  EXPECT_THROW(space.add(SweptSpace(kBox, 2 * kSpacing)), std::invalid_argument);
  for (const double bad : {std::nan(""), std::numeric_limits<double>::infinity()}) {
    space.add_ball({bad, 0, 0.1}, 0.01);
    EXPECT_EQ(space.depth({bad, 0, 0.1}), 0);
  }
  space.add_ball({0, 0, 0.1}, 0);
  space.add_ball({0, 0, 0.1}, std::nan(""));
  EXPECT_TRUE(space.empty());
}

}  // namespace
}  // namespace prehend::geometry
