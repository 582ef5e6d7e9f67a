// The way down to a place goes on until what is held is felt to stand, or ends where it is
// predicted to.

#include <utility>

#include <gtest/gtest.h>

#include "tests/control/arm_cycle_fixture.h"

namespace prehend::control {
namespace {

constexpr std::size_t kPlace = 5;  // of the paths that are asked for

ArmGrasp guarded_grasp() {
  ArmGrasp grasp = fake_grasp();
  grasp.place_share = 0.6;
  return grasp;
}

ArmCycleOptions reacting() {
  ArmCycleOptions options;
  options.reacts = true;
  return options;
}

// Where the way down ends.
double placed_at(Fakes& f, const ArmCycleOptions& options) {
  ArmCycle cycle(options, f.arm, f.hand);
  cycle.start({guarded_grasp()});
  f.run(cycle, 4000, kPlace);
  EXPECT_EQ(f.arm.asked.size(), kPlace) << cycle.result().reason;
  return f.arm.asked.empty() ? 0 : f.arm.asked.back().points.back().position[0];
}

TEST(GuardedPlace, GoesOnWhereItIsFeltToStand) {
  Fakes f;
  EXPECT_EQ(placed_at(f, reacting()), 5);
  EXPECT_LT(f.arm.forces.back(), ArmCycleOptions{}.collision_force) << "it stops there";
}

TEST(GuardedPlace, EndsWhereItIsPredictedToStandWhereNothingIsReactedTo) {
  Fakes f;
  const double end = placed_at(f, {});
  EXPECT_GT(end, 4.4);
  EXPECT_LT(end, 4.8);
}

// Of 2 s it is to stand after 1.2; where it ends there, it takes 2.25 s, as it comes to rest.
TEST(GuardedPlace, WhatIsMetBeforeItIsToStandIsASurprise) {
  struct Met {
    bool reacts;
    double after;  // s
    bool is_early;
  };
  for (const auto& [reacts, met, is_early] : {Met{true, 0.5, true}, Met{true, 1.0, false},
                                              Met{false, 1.4, true}, Met{false, 1.8, false}}) {
    Fakes f;
    ArmCycleOptions options;
    options.reacts = reacts;
    ArmCycle cycle(options, f.arm, f.hand);
    cycle.start({guarded_grasp()});
    double begun = 0;  // s
    for (int i = 0; i < 4000 && !cycle.finished(); ++i) {
      f.now.time += 0.02;
      if (f.arm.asked.size() < kPlace) begun = f.now.time;
      f.arm.says[kPlace] =
          f.now.time - begun < met ? MotionStatus::kMoving : MotionStatus::kContact;
      cycle.step(f.felt());
    }
    EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
    EXPECT_EQ(surprise_of(cycle, SurpriseKind::kTouchedTooEarly) != nullptr, is_early) << met;
  }
}

TEST(GuardedPlace, WhatStandsIsLetGoThereAndLeft) {
  Fakes f;
  ArmCycle cycle(reacting(), f.arm, f.hand);
  f.arm.says[kPlace] = MotionStatus::kContact;
  cycle.start({guarded_grasp()});
  f.run(cycle);
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  ASSERT_GT(f.arm.asked.size(), kPlace);
  EXPECT_EQ(f.arm.asked[kPlace].points.front().position[0], 5) << "the retreat begins where it is";
}

}  // namespace
}  // namespace prehend::control
