#include "prehend/grasp/closing/close_pads.h"

#include <cmath>
#include <numbers>
#include <random>
#include <stdexcept>

#include <gtest/gtest.h>

namespace prehend::grasp {
namespace {

using geometry::make_transform;
using geometry::MeshQuery;
using geometry::RigidTransform;

const robot::GripperModel kGripper;

RigidTransform hand_at(double x, double y, double z, double turn_about_z = 0) {
  return make_transform(
      Eigen::Quaterniond(Eigen::AngleAxisd(turn_about_z, Eigen::Vector3d::UnitZ())), {x, y, z});
}

TEST(CloseHand, FlatFacesShareTheForceOverAllTexels) {
  const MeshQuery box(geometry::make_box({0.06, 0.05, 0.1}));
  const double force = 10;
  const ClosedHand hand = close_hand(box, hand_at(0, 0, 0), 0.069, force, kGripper);
  ASSERT_EQ(hand.outcome, ClosingOutcome::kClosed);
  const double texels = kGripper.pad.rows * kGripper.pad.columns;
  const double depth = force / (texels * kGripper.pad.law.stiffness);
  EXPECT_NEAR(hand.opening, 0.05 - 2 * depth, 1e-6);
  EXPECT_NEAR(hand.left.depth, depth, 1e-6);
  EXPECT_NEAR(hand.left.force, force, 1e-2);
  EXPECT_NEAR(hand.right.force, force, 1e-2);
  EXPECT_NEAR(hand.left.area, texels * kGripper.pad.texel_pitch * kGripper.pad.texel_pitch, 1e-12);
  EXPECT_NEAR(hand.opening_at_touch, 0.05, 2e-5);
  EXPECT_NEAR(hand.turn, 0, 1e-5);
  EXPECT_NEAR((hand.left.normal_G - Eigen::Vector3d::UnitY()).norm(), 0, 1e-5);
  EXPECT_NEAR((hand.right.normal_G + Eigen::Vector3d::UnitY()).norm(), 0, 1e-5);
}

TEST(CloseHand, SpherePressesACapByTheSpringLaw) {
  // Winkler's bed under a sphere: F = k/p^2 pi R d^2 for depth d << R, patch radius sqrt(2 R d).
  const double radius = 0.03, force = 10;
  const MeshQuery ball(geometry::make_sphere(radius, 256));
  const ClosedHand hand = close_hand(ball, hand_at(0, 0, 0), 0.069, force, kGripper);
  ASSERT_EQ(hand.outcome, ClosingOutcome::kClosed);
  const double p = kGripper.pad.texel_pitch;
  const double bed = kGripper.pad.law.stiffness / (p * p);
  const double depth = std::sqrt(force / (bed * std::numbers::pi * radius));
  EXPECT_NEAR((2 * radius - hand.opening) / 2, depth, 0.1 * depth);  // 84 texels see it coarsely
  EXPECT_NEAR(hand.left.area, 2 * std::numbers::pi * radius * depth, 4 * p * p);
  EXPECT_NEAR(hand.left.center_G.x(), 0, 1e-5);
  EXPECT_NEAR(hand.left.center_G.z(), 0, 1e-5);
}

TEST(CloseHand, AMeasuredSectionSavesTheRays) {
  const MeshQuery ball(geometry::make_sphere(0.03, 96));
  const auto X_WG = hand_at(0.004, 0.003, 0.01);
  SectionExtent section = measure_section(ball, X_WG, kGripper);
  ASSERT_TRUE(section.met);
  const double offset = (section.upper + section.lower) / 2;
  section.shift_hand(offset);
  EXPECT_NEAR(section.upper, -section.lower, 1e-12);
  const auto centred = hand_at(0.004, 0.003 + offset, 0.01);
  const ClosedHand by_rays = close_hand(ball, centred, 0.069, 10, kGripper);
  const ClosedHand by_section = close_hand(ball, centred, 0.069, 10, kGripper, {}, &section);
  ASSERT_EQ(by_section.outcome, by_rays.outcome);
  EXPECT_NEAR(by_section.opening, by_rays.opening, 1e-6);
  EXPECT_NEAR(by_section.left.force, by_rays.left.force, 1e-3);
  EXPECT_NEAR(by_section.turn, by_rays.turn, 1e-4);
}

// The rest is where the energy is least: no nearby rest has less (checked by brute force).
TEST(CloseHand, EndsAtTheLeastEnergy) {
  const MeshQuery box(geometry::transformed(
      geometry::make_box({0.06, 0.04, 0.1}),
      geometry::make_transform(
          Eigen::Quaterniond(Eigen::AngleAxisd(0.05, Eigen::Vector3d::UnitZ())), {0, 0, 0})));
  const ClosedHand hand = close_hand(box, hand_at(0, 0, 0), 0.069, 10, kGripper);
  ASSERT_EQ(hand.outcome, ClosingOutcome::kClosed);
  EXPECT_NEAR(hand.turn, 0.05, 2e-3);  // turned until its faces lie on the pads
  EXPECT_NEAR(hand.left.force, 10, 0.05);
  EXPECT_NEAR(hand.right.force, 10, 0.05);
}

TEST(CloseHand, MoreForceMoreDepthMoreArea) {
  const MeshQuery ball(geometry::make_sphere(0.03, 128));
  double opening = 1, area = 0;
  for (double force : {2.0, 5.0, 10.0, 20.0}) {
    const ClosedHand hand = close_hand(ball, hand_at(0, 0, 0), 0.069, force, kGripper);
    EXPECT_LT(hand.opening, opening);
    EXPECT_GE(hand.left.area, area);
    EXPECT_NEAR(hand.left.force, force, 0.01 * force);
    opening = hand.opening;
    area = hand.left.area;
  }
}

TEST(CloseHand, OffCentreObjectTellsItsOffset) {
  const MeshQuery box(geometry::make_box({0.06, 0.04, 0.1}));
  // The hand is 5 mm beside the box, so the box is 5 mm towards -y of the hand.
  const ClosedHand hand = close_hand(box, hand_at(0, 0.005, 0), 0.069, 10, kGripper);
  EXPECT_EQ(hand.outcome, ClosingOutcome::kClosed);
  EXPECT_NEAR(hand.offset, -0.005, 1e-6);
  EXPECT_NEAR(hand.opening_at_touch, 0.04, 1e-4);
}

TEST(CloseHand, SlightlyTurnedBoxIsAligned) {
  const double turn = 3 * std::numbers::pi / 180;
  const MeshQuery box(geometry::make_box({0.05, 0.05, 0.1}));
  const ClosedHand hand = close_hand(box, hand_at(0, 0, 0, turn), 0.069, 20, kGripper);
  ASSERT_EQ(hand.outcome, ClosingOutcome::kClosed);
  EXPECT_NEAR(hand.turn, turn, 0.1 * turn);
  // Once aligned, the pads lie flat on the faces.
  EXPECT_NEAR(std::abs(hand.left.normal_G.y()), 1, 1e-4);
  EXPECT_GT(hand.left.area, 0.9 * kGripper.pad.length() * kGripper.pad.width());
}

TEST(CloseHand, FarTurnedBoxTurns) {
  const MeshQuery box(geometry::make_box({0.05, 0.04, 0.1}));
  const ClosedHand hand =
      close_hand(box, hand_at(0, 0, 0, 20 * std::numbers::pi / 180), 0.069, 20, kGripper);
  EXPECT_EQ(hand.outcome, ClosingOutcome::kTurns);
}

TEST(CloseHand, TooWideMissedAndBottomedOut) {
  const MeshQuery wide(geometry::make_box({0.1, 0.094, 0.1}));
  EXPECT_EQ(close_hand(wide, hand_at(0, 0, 0), 0.069, 10, kGripper).outcome,
            ClosingOutcome::kTooWide);
  const MeshQuery box(geometry::make_box({0.05, 0.05, 0.05}));
  EXPECT_EQ(close_hand(box, hand_at(0.2, 0, 0), 0.069, 10, kGripper).outcome,
            ClosingOutcome::kMissed);
  // A needle of one texel takes no more than k * thickness = 3 N.
  const MeshQuery needle(geometry::make_box({0.003, 0.02, 0.003}));
  EXPECT_EQ(close_hand(needle, hand_at(0.0017, 0, 0.0017), 0.069, 10, kGripper).outcome,
            ClosingOutcome::kBottomsOut);
}

TEST(CloseHand, RimThatReachesAFingerAboveThePadIsRefused) {
  // A can's body with a rim at its top, above the pads.
  const auto can_with_rim = [](double rim) {
    geometry::TriangleMesh mesh =
        geometry::concatenated({geometry::make_box({0.05, 0.05, 0.1}),
                                geometry::make_box({0.05 + 2 * rim, 0.05 + 2 * rim, 0.006})});
    // The housing is at -z of the gripper frame.
    for (std::size_t i = 8; i < mesh.vertices.size(); ++i) mesh.vertices[i].z() -= 0.04;
    return geometry::MeshQuery(mesh);
  };
  const auto hand = hand_at(0, 0, 0);
  EXPECT_EQ(close_hand(can_with_rim(0.002), hand, 0.069, 10, kGripper).outcome,
            ClosingOutcome::kClosed);  // behind the foam's thickness of 3 mm
  EXPECT_EQ(close_hand(can_with_rim(0.005), hand, 0.069, 10, kGripper).outcome,
            ClosingOutcome::kTouchesFinger);
}

TEST(CloseHand, RejectsNonsense) {
  const MeshQuery box(geometry::make_box({0.05, 0.05, 0.05}));
  EXPECT_THROW(close_hand(box, hand_at(0, 0, 0), 0, 10, kGripper), std::invalid_argument);
  EXPECT_THROW(close_hand(box, hand_at(0, 0, 0), 0.05, -1, kGripper), std::invalid_argument);
  ClosingOptions options;
  options.touch_force = 0;
  EXPECT_THROW(close_hand(box, hand_at(0, 0, 0), 0.05, 1, kGripper, options),
               std::invalid_argument);
}

TEST(MeasureSection, TellsWidthsBeyondTheGripper) {
  const MeshQuery wide(geometry::make_box({0.1, 0.094, 0.1}));
  const SectionExtent section = measure_section(wide, hand_at(0, 0.01, 0), kGripper);
  ASSERT_TRUE(section.met);
  EXPECT_NEAR(section.upper, 0.037, 1e-6);
  EXPECT_NEAR(section.lower, -0.057, 1e-6);
  EXPECT_FALSE(measure_section(wide, hand_at(0.3, 0, 0), kGripper).met);
  EXPECT_LT(least_section_width(wide, hand_at(0.3, 0, 0), kGripper), 0);
}

TEST(MeasureSection, AFewTexelsTellAtLeastHowWideItIs) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> part(-1, 1);
  int close = 0, met = 0;
  for (const auto& mesh : {geometry::make_box({0.1, 0.06, 0.08}), geometry::make_sphere(0.04, 64),
                           geometry::make_box({0.02, 0.2, 0.03})}) {
    const MeshQuery object(mesh);
    for (int i = 0; i < 300; ++i) {
      auto X_WG = hand_at(0.04 * part(random), 0.05 * part(random), 0.04 * part(random));
      X_WG.rotate(
          Eigen::Quaterniond(part(random), part(random), part(random), part(random)).normalized());
      const double least = least_section_width(object, X_WG, kGripper);
      const SectionExtent section = measure_section(object, X_WG, kGripper);
      if (!section.met) {
        EXPECT_LT(least, 0);
        continue;
      }
      EXPECT_LE(least, section.upper - section.lower + 1e-9);
      ++met;
      close += least > 0.9 * (section.upper - section.lower);
    }
  }
  EXPECT_GT(close, 2 * met / 3);  // or it would save nothing
}

}  // namespace
}  // namespace prehend::grasp
