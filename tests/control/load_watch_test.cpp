// What holds of the shipped cycle tell of an object's load, against what the world has.

#include "prehend/control/load_watch.h"

#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "prehend/belief/load_belief.h"
#include "prehend/control/arm_in_world.h"
#include "prehend/control/attempt_watch.h"
#include "prehend/geometry/gravity.h"
#include "prehend/simulation/shapes.h"
#include "tests/control/pick_of.h"

namespace prehend::control {
namespace {

class LoadOfBox : public testing::TestWithParam<const char*> {
 protected:
  // One cycle with a box of that mass [kg] and friction.
  AttemptWatch watched(double mass, double friction) {
    simulation::Scene scene;
    scene.wrench.emplace();
    scene.wrench->force_noise = 0.1;
    simulation::RobotWorld world(planned_.platform(), scene, "side");
    world.add_object("thing", mesh_W_, mass, false, friction);
    ArmInWorld arm(world);
    ArmCycleOptions options = reacting();
    options.largest_attempts = 1;
    CycleInWorld in_world(arm, options);
    AttemptWatch watch(planned_.platform(), options.contact_force);
    in_world.run(planned_.to_try(planned_.plan(mesh_W_)), nullptr,
                 [&] { watch.step(in_world.cycle(), in_world.percepts()); });
    for (const Surprise& surprise : in_world.cycle().surprises()) {
      slips_ += surprise.kind == SurpriseKind::kSlip && surprise.felt > 0 ? 1 : 0;
    }
    reason_ = in_world.cycle().result().reason;
    return watch;
  }

  const PickOf planned_{GetParam()};
  const geometry::TriangleMesh mesh_W_ = simulation::make_standing_box({0.05, 0.05, 0.14});
  int slips_ = 0;
  std::string reason_;
};

TEST_P(LoadOfBox, IsWeighedAndItsFrictionIsAtLeastWhatHeldIt) {
  constexpr double kMass = 0.4, kFriction = 0.7;
  const AttemptWatch watch = watched(kMass, kFriction);
  EXPECT_EQ(watch.load().concluded(), 1) << reason_;
  const belief::LoadEvidence& found = watch.load().found();
  ASSERT_TRUE(found.weight) << reason_;
  const belief::LoadBelief belief = belief::load_belief({found});
  EXPECT_EQ(belief.contradiction, "");
  EXPECT_LT(belief.bounds.mass.low, kMass);
  EXPECT_GT(belief.bounds.mass.high, kMass);
  EXPECT_LT(belief.bounds.mass.high - belief.bounds.mass.low, 0.06);
  EXPECT_LT(belief.bounds.friction.low, kFriction);
  EXPECT_GE(belief.bounds.friction.high, kFriction);
}

// Heavy and slippery: whatever is said of it must be true.
TEST_P(LoadOfBox, WhatSlipsBoundsTheFrictionFromAbove) {
  constexpr double kMass = 1.2, kFriction = 0.2;
  const AttemptWatch watch = watched(kMass, kFriction);
  const belief::LoadEvidence& found = watch.load().found();
  const belief::LoadBelief belief = belief::load_belief({found});
  EXPECT_EQ(belief.contradiction, "");
  EXPECT_LT(belief.bounds.mass.low, kMass);
  EXPECT_GT(belief.bounds.mass.high, kMass);
  EXPECT_LT(belief.bounds.friction.low, kFriction);
  EXPECT_GT(belief.bounds.friction.high, kFriction);
  // The fingers of the SDH-2 hold it all the same; the jaws let it slip, which has to be told.
  if (std::string(GetParam()) == "stage_pg70") {
    EXPECT_GT(slips_, 0) << reason_;
    EXPECT_TRUE(found.borne);
  }
}

INSTANTIATE_TEST_SUITE_P(Platforms, LoadOfBox, testing::Values("stage_pg70", "kr5_sdh"));

}  // namespace
}  // namespace prehend::control
