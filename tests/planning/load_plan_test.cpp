// What was found out of an object's load is planned with.

#include <gtest/gtest.h>

#include "prehend/geometry/gravity.h"
#include "prehend/planning/platform_plan.h"
#include "prehend/surface/model.h"

namespace prehend::planning {
namespace {

using geometry::kGravity;

constexpr double kVolume = 0.05 * 0.05 * 0.14;  // m^3

class LoadPlan : public testing::Test {
 protected:
  LoadPlan() {
    options.grasps.threads = 1;
    options.grasps.uncertainty.samples = 4;
    options.motions = 1;
    options.arm.pick.budget = 0;
  }
  PlatformPlan plan() const {
    const geometry::TriangleMesh mesh = geometry::transformed(
        geometry::make_box({0.05, 0.05, 0.14}),
        geometry::make_transform(Eigen::Quaterniond::Identity(), {0, 0, 0.07}));
    return planner.plan(surface::model_of_mesh(mesh), {}, {}, {},
                        planner.platform().home("home").arm, options);
  }
  // As pads' force is planned where the middle of mass is in the grip.
  double force(double mass, double friction) const {
    return options.grasps.safety_factor * mass * (kGravity + options.grasps.lift_acceleration) /
           (2 * friction);
  }

  const PlatformPlanner planner{robot::read_platform("config/robots/stage_pg70.yaml")};
  PlatformPlanOptions options{planner.platform().hand};
};

TEST_F(LoadPlan, AKnownMassIsPlannedWith) {
  options.load.mass = {0.95, 1.05};
  const PlatformPlan heavy = plan();
  ASSERT_FALSE(heavy.picks.empty()) << heavy.problem;
  for (const PlannedPick& pick : heavy.picks) {
    EXPECT_NEAR(pick.grasp.predicted.lifted_mass, 1.05, 1e-6);
    EXPECT_GE(pick.grasp.force, force(1.05, options.grasps.pads.friction) - 1e-6);
  }
}

TEST_F(LoadPlan, WhatSlippedIsGrippedHarder) {
  const PlatformPlan before = plan();
  options.load.friction.high = 0.4;
  const PlatformPlan after = plan();
  ASSERT_FALSE(before.picks.empty());
  ASSERT_FALSE(after.picks.empty()) << after.problem;
  const double mass = after.picks.front().grasp.predicted.lifted_mass;
  for (const PlannedPick& pick : after.picks) EXPECT_GE(pick.grasp.force, force(mass, 0.4) - 1e-6);
  EXPECT_GT(after.picks.front().grasp.force, before.picks.front().grasp.force);
}

// It weighs more than was assumed of anything, or has slipped at the greatest force.
TEST_F(LoadPlan, WhatIsTooHeavyOrTooSlipperyIsRefused) {
  options.remedies.budget = 0;
  options.load.mass = {40, 45};
  EXPECT_EQ(plan().outcome, grasp::PlanOutcome::kUngraspable);
  options.load = {};
  options.load.friction.high = 0.02;
  EXPECT_EQ(plan().outcome, grasp::PlanOutcome::kUngraspable);
}

TEST_F(LoadPlan, WithinLoadChangesWhatIsKnownAlone) {
  const PlatformPlanOptions before = options;
  robot::HandModel hand = planner.platform().hand;
  const double friction = hand.friction;
  within_load({}, kVolume, &options, &hand);
  EXPECT_EQ(options.grasps.density, before.grasps.density);
  EXPECT_EQ(options.grasps.hollow_share, before.grasps.hollow_share);
  EXPECT_EQ(options.grasps.pads.friction, before.grasps.pads.friction);
  EXPECT_EQ(hand.friction, friction);

  options.grip_force = 5;
  within_load({{0.1, 0.11}, {}}, kVolume, &options, &hand);
  EXPECT_NEAR(options.grasps.density * kVolume, 0.11, 1e-9);
  EXPECT_NEAR(options.grasps.density * options.grasps.hollow_share * kVolume, 0.105, 0.0051);
  EXPECT_EQ(options.grip_force, 5) << "nothing says that it slips";
  EXPECT_EQ(hand.friction, friction);

  within_load({{0.1, 0.11}, {0, 0.05}}, kVolume, &options, &hand);
  EXPECT_DOUBLE_EQ(hand.friction, 0.05);
  EXPECT_DOUBLE_EQ(options.grasps.pads.friction, 0.05);
  EXPECT_DOUBLE_EQ(options.grasps.uncertainty.largest_friction, 0.05);
  EXPECT_LT(options.grasps.uncertainty.least_friction, 0.05);
  EXPECT_NEAR(options.grip_force, force(0.11, 0.05), 1e-6);
  options.validate();
}

}  // namespace
}  // namespace prehend::planning
