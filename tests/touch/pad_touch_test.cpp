#include "prehend/touch/pad_touch.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include <limits>
#include <memory>

#include "prehend/contact/compression_curve.h"
#include "prehend/contact/texel.h"
#include "prehend/geometry/triangle_mesh.h"
#include "tests/touch/pressed.h"

namespace prehend::touch {
namespace {

using testing::ball;
using ::testing::Contains;
using testing::fine_pad;
using ::testing::HasSubstr;
using testing::pressed;

constexpr double kTexelArea = 0.0034 * 0.0034;

TEST(PadTouch, ABallGivesItsCentreAndItsCurvature) {
  const FeltPad pad = fine_pad();
  for (const double radius : {0.015, 0.03, 0.1}) {
    for (const double x : {0.0, 0.0013}) {
      const PadTouch touch = pad_touch(pad, pressed(pad, ball(radius, 0.0015, x, 0.004)));
      ASSERT_TRUE(touch.center && touch.normal && touch.curvature) << radius;
      EXPECT_NEAR(touch.center->x(), x, 1e-3);
      EXPECT_NEAR(touch.center->y(), 0.004, 1e-3);
      EXPECT_NEAR(touch.curvature->largest, 1 / radius, 0.06 / radius) << radius;
      EXPECT_NEAR(touch.curvature->smallest, 1 / radius, 0.06 / radius) << radius;
      // The radius to the centre of pressure.
      const Eigen::Vector3d expected(-(touch.center->x() - x) / radius,
                                     -(touch.center->y() - 0.004) / radius, 1);
      EXPECT_LT((touch.normal->direction + expected.normalized()).norm(), 2.01);
      EXPECT_GT(touch.normal->direction.dot(Eigen::Vector3d(0, 0, 1)), 0.999);
      EXPECT_TRUE(touch.not_determined.empty());
    }
  }
}

TEST(PadTouch, ACylinderIsCurvedAcrossItsAxis) {
  const FeltPad pad = fine_pad();
  const double radius = 0.02, angle = 0.4;
  const PadTouch touch = pad_touch(
      pad, pressed(pad, [&](double x, double y) {
        const double across = std::cos(angle) * x + std::sin(angle) * y;
        return 0.0015 - radius + std::sqrt(radius * radius - std::min(across * across, 2e-4));
      }));
  ASSERT_TRUE(touch.curvature);
  EXPECT_NEAR(touch.curvature->largest, 1 / radius, 3);
  EXPECT_NEAR(touch.curvature->smallest, 0, 2);
  EXPECT_NEAR(std::abs(touch.curvature->direction.dot(
                  Eigen::Vector3d(std::cos(angle), std::sin(angle), 0))),
              1, 1e-3);
}

TEST(PadTouch, ATiltedPlateGivesItsNormalAndAHollowIsNegative) {
  const FeltPad pad = fine_pad();
  const double a = 0.02, b = -0.03;  // slopes of the depth
  const PadTouch plate =
      pad_touch(pad, pressed(pad, [&](double x, double y) { return 0.0013 + a * x + b * y; }));
  ASSERT_TRUE(plate.normal && plate.curvature);
  EXPECT_LT((plate.normal->direction - Eigen::Vector3d(a, b, 1).normalized()).norm(), 1e-4);
  EXPECT_NEAR(plate.curvature->largest, 0, 0.01);
  EXPECT_EQ(plate.touched, 84);
  EXPECT_NEAR(plate.area, 84 * kTexelArea, 1e-12);
  EXPECT_NEAR(plate.force, 84 * 1000 * 0.0013, 1e-3);  // the slopes sum to nothing
  const PadTouch hollow = pad_touch(
      pad, pressed(pad, [](double x, double y) { return 0.0005 + 10 * (x * x + y * y) / 2; }));
  ASSERT_TRUE(hollow.curvature);
  EXPECT_NEAR(hollow.curvature->smallest, -10, 0.1);
}

TEST(PadTouch, TheHoldingTorqueOfADiscIsTwoThirdsOfMuFR) {
  const FeltPad pad = fine_pad(8);
  const double radius = 0.008;
  PadTouchOptions options;
  options.friction = 0.5;
  const PadTouch touch = pad_touch(
      pad, pressed(pad, [&](double x, double y) { return std::hypot(x, y) < radius ? 1e-3 : 0; }),
      options);
  ASSERT_TRUE(touch.holding_torque);
  EXPECT_NEAR(*touch.holding_torque, 2.0 / 3 * 0.5 * touch.force * radius,
              0.01 * *touch.holding_torque);
  EXPECT_NEAR(touch.force, 1000 * 1e-3 * std::numbers::pi * radius * radius / kTexelArea,
              0.02 * touch.force);
  // By the law's own friction without another.
  const PadTouch own = pad_touch(
      pad, pressed(pad, [&](double x, double y) { return std::hypot(x, y) < radius ? 1e-3 : 0; }));
  EXPECT_NEAR(*own.holding_torque / *touch.holding_torque, pad.law.dynamic_friction / 0.5, 1e-9);
}

TEST(PadTouch, SaysWhatIsNotDetermined) {
  const FeltPad pad = fine_pad();
  std::vector<double> counts(84, 0.0);
  const PadTouch nothing = pad_touch(pad, counts);
  EXPECT_EQ(nothing.touched, 0);
  EXPECT_FALSE(nothing.center || nothing.normal || nothing.curvature || nothing.holding_torque);
  EXPECT_THAT(nothing.not_determined, Contains(HasSubstr("nothing touches")));

  counts[40] = 5e5;
  const PadTouch one = pad_touch(pad, counts);
  EXPECT_EQ(one.touched, 1);
  EXPECT_NEAR(one.force, 0.5, 1e-12);
  ASSERT_TRUE(one.center);
  EXPECT_LT((*one.center - pad.layout.position(40)).norm(), 1e-12);
  EXPECT_FALSE(one.normal || one.curvature || one.holding_torque);
  EXPECT_THAT(one.not_determined, Contains("normal: 1 texels to fit, 3 are needed"));
  EXPECT_THAT(one.not_determined, Contains("holding_torque: within one texel"));

  std::vector<double> column(84, 0.0);
  for (int row = 2; row < 10; ++row) column[row * 6 + 3] = 4e5;
  const PadTouch line = pad_touch(pad, column);
  EXPECT_FALSE(line.normal || line.curvature);
  EXPECT_THAT(line.not_determined, Contains("normal: the touched texels lie on one line"));
  EXPECT_TRUE(line.holding_torque);

  std::vector<double> corner(84, 0.0);
  for (const int i : {40, 41, 46, 47}) corner[i] = 4e5;
  const PadTouch square = pad_touch(pad, corner);
  EXPECT_TRUE(square.normal);
  EXPECT_THAT(square.not_determined, Contains("curvature: 4 texels to fit, 6 are needed"));
}

TEST(PadTouch, TexelsThatSayNoCountAreLeftOutAndFullOnesDoNotBendTheSurface) {
  FeltPad pad = fine_pad();
  std::vector<double> counts =
      pressed(pad, [](double x, double y) { return 0.001 + 0.01 * x + 0.02 * y; });
  const PadTouch whole = pad_touch(pad, counts);
  counts[3] = std::numeric_limits<double>::quiet_NaN();
  counts[10] = std::numeric_limits<double>::infinity();
  counts[20] = -5;
  const PadTouch some = pad_touch(pad, counts);
  EXPECT_EQ(some.unreadable, 3);
  EXPECT_EQ(some.touched, 81);
  ASSERT_TRUE(some.normal && some.center);
  EXPECT_TRUE(some.center->allFinite());
  EXPECT_LT((some.normal->direction - whole.normal->direction).norm(), 1e-4);

  pad.full_scale = 1'100'000;  // cuts the deeper part
  for (double& count : counts) count = std::min(count, 1.1e6);
  const PadTouch cut = pad_touch(pad, counts);
  EXPECT_GT(cut.full, 5);
  ASSERT_TRUE(cut.normal);
  EXPECT_LT((cut.normal->direction - whole.normal->direction).norm(), 1e-3);
  const PadTouch full = pad_touch(pad, std::vector<double>(84, 1.1e6));
  EXPECT_EQ(full.full, 84);
  EXPECT_FALSE(full.normal || full.curvature);
  EXPECT_TRUE(full.center && full.holding_torque);

  const PadTouch blind = pad_touch(pad, std::vector<double>(84, std::nan("")));
  EXPECT_EQ(blind.unreadable, 84);
  EXPECT_THAT(blind.not_determined, Contains(HasSubstr("no texel can be read")));
  EXPECT_THROW(pad_touch(pad, std::vector<double>(83, 0.0)), std::invalid_argument);
}

TEST(PadTouch, SpreadOfGainsShowsInTheDeviations) {
  const FeltPad pad = fine_pad();
  std::vector<double> counts = pressed(pad, ball(0.03, 0.0015, 0, 0));
  for (std::size_t i = 0; i < counts.size(); ++i) counts[i] *= i % 2 ? 1.1 : 0.9;
  const PadTouch touch = pad_touch(pad, counts);
  ASSERT_TRUE(touch.curvature && touch.normal);
  EXPECT_NEAR(touch.curvature->largest, 1 / 0.03, 4 * touch.curvature->deviation);
  EXPECT_GT(touch.curvature->deviation, 0.5);
}

TEST(PadTouch, AMirroredPadIsThePadSeenFromBehind) {
  robot::TactilePadModel model;
  const FeltPad pad = felt_pad(model), mirrored = felt_pad(model, true);
  std::vector<double> counts(84, 0.0);
  counts[6 * 4 + 1] = 800;
  const auto a = pad_touch(pad, counts).center, b = pad_touch(mirrored, counts).center;
  ASSERT_TRUE(a && b);
  EXPECT_NEAR(a->x(), -b->x(), 1e-12);
  EXPECT_NEAR(a->y(), b->y(), 1e-12);
  EXPECT_GT(a->y(), 0) << "row 0 is at +y";
}

TEST(PadTouch, OnAFingertipTheNormalIsTheTexels) {
  geometry::TriangleMesh ball = geometry::make_sphere(0.01, 32);
  std::erase_if(ball.triangles, [&](const Eigen::Vector3i& t) {
    return ball.vertices[t[0]].z() + ball.vertices[t[1]].z() + ball.vertices[t[2]].z() < 0;
  });
  FeltPad tip{contact::PadLayout::curved(ball, 0.002), {}, 1e-6, 100'000'000};
  // A plane, off the top, presses the ball in: depth along the texel's normal.
  const Eigen::Vector3d n = Eigen::Vector3d(0.3, -0.2, 1).normalized();
  std::vector<double> counts;
  for (std::size_t i = 0; i < tip.layout.size(); ++i) {
    const double over = n.dot(tip.layout.position(i)) - 0.0092;
    const double depth = over / n.dot(tip.layout.normal(i));
    counts.push_back(over > 0 ? tip.layout.scale[i] * tip.law.stiffness * depth / 1e-6 : 0.0);
  }
  const PadTouch touch = pad_touch(tip, counts);
  ASSERT_TRUE(touch.normal && touch.curvature);
  EXPECT_LT((touch.normal->direction - n).norm(), 0.01);
  EXPECT_NEAR(touch.curvature->largest, 0, 3);
}

TEST(RestDepth, IsTheInverseOfEachLaw) {
  std::vector<contact::TexelLaw> laws(3);
  laws[1].normal_law = contact::NormalLaw::kHuntCrossley;
  laws[1].stiffness = 4e4;
  laws[2].normal_law = contact::NormalLaw::kTabulated;
  laws[2].curve = std::make_shared<contact::CompressionCurve>(
      std::vector<contact::CompressionCurve::Sample>{{0, 0}, {1e-3, 0.6}, {3e-3, 4}});
  for (const contact::TexelLaw& law : laws) {
    for (const double depth : {1e-5, 4e-4, 2.3e-3}) {
      const double force = 0.25 * contact::normal_force(law, depth, 0);
      EXPECT_NEAR(rest_depth(law, 0.25, force, 3e-3), depth, 1e-9);
    }
    EXPECT_EQ(rest_depth(law, 1, 1e6, 3e-3), 3e-3);
    EXPECT_EQ(rest_depth(law, 1, 0, 3e-3), 0);
  }
}

}  // namespace
}  // namespace prehend::touch
