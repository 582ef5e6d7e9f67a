#include "prehend/simulation/shapes.h"

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::simulation {
namespace {

using geometry::TriangleMesh;

void expect_solid(const TriangleMesh& mesh, double height, const char* name) {
  const geometry::MeshDefects defects = geometry::find_defects(mesh);
  EXPECT_TRUE(defects.watertight()) << name << ": " << defects.to_string();
  EXPECT_GT(geometry::mass_properties(mesh).volume, 0) << name;
  const Eigen::AlignedBox3d box = geometry::bounds(mesh);
  EXPECT_NEAR(box.min().z(), 0, 1e-12) << name;
  EXPECT_NEAR(box.max().z(), height, 1e-12) << name;
}

TEST(Shapes, AreWatertightAndStandOnTheTable) {
  expect_solid(make_standing_box({0.05, 0.06, 0.1}), 0.1, "box");
  expect_solid(make_can(0.03, 0.1), 0.1, "can");
  expect_solid(make_bottle(0.035, 0.22), 0.22, "bottle");
  expect_solid(make_mug(0.04, 0.09), 0.09, "mug");
  expect_solid(make_spray_bottle(0.07, 0.05, 0.2), 0.2, "spray_bottle");
  expect_solid(make_ball(0.03), 0.06, "ball");
}

TEST(Shapes, HaveTheVolumesOfTheirFormulas) {
  EXPECT_NEAR(geometry::mass_properties(make_standing_box({0.05, 0.06, 0.1})).volume, 3e-4, 1e-12);
  const double can = std::numbers::pi * 0.03 * 0.03 * 0.1;
  EXPECT_NEAR(geometry::mass_properties(make_can(0.03, 0.1)).volume, can, 0.02 * can);
  const double ball = 4.0 / 3 * std::numbers::pi * std::pow(0.03, 3);
  EXPECT_NEAR(geometry::mass_properties(make_ball(0.03)).volume, ball, 0.01 * ball);
}

TEST(Shapes, MugIsHollow) {
  const double full = std::numbers::pi * 0.04 * 0.04 * 0.09;
  EXPECT_LT(geometry::mass_properties(make_mug(0.04, 0.09)).volume, 0.4 * full);
}

TEST(Shapes, RefuseBadDimensions) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(make_standing_box({0, 1, 1}), std::invalid_argument);
  EXPECT_THROW(make_can(nan, 0.1), std::invalid_argument);
  EXPECT_THROW(make_bottle(0.03, -1), std::invalid_argument);
  EXPECT_THROW(make_mug(0.04, 0.09, 0.03), std::invalid_argument);
  EXPECT_THROW(make_spray_bottle(0.07, 0, 0.2), std::invalid_argument);
  EXPECT_THROW(make_ball(std::numeric_limits<double>::infinity()), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::simulation
