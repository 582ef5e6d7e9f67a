// What the cycle makes of what fingers and pads feel, against ports that say what the test wants.

#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/control/arm_cycle_fixture.h"

namespace prehend::control {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

// Two fingers against each other along x, and a hand that can follow to both sides.
ArmGrasp adapting_grasp() {
  ArmGrasp grasp = fake_grasp();
  grasp.hand_joints = {"f", "g"};
  const auto two = [](double value) { return Eigen::VectorXd::Constant(2, value); };
  grasp.hand = {two(0.1), two(0.6), two(1), two(-1), two(2)};
  grasp.stops = two(0.6);
  grasp.fingertips.ways.resize(3, 2);
  grasp.fingertips.ways << 0.1, -0.1, 0, 0, 0, 0;
  grasp.fingertips.finger = {0, 1};
  grasp.shifts = {{{0.02, 0, 0}, {0.5}}, {{-0.02, 0, 0}, {-0.5}}};
  return grasp;
}

// Fingers that are stopped where the test wants.
struct TwoFingers : FakeHand {
  std::vector<double> positions() override { return last_closes ? stopped : asked_all; }
  void move(const std::vector<std::string>& joints, const std::vector<double>& positions,
            double speed, bool until_contact, const std::vector<double>& effort) override {
    asked_all = positions;
    FakeHand::move(joints, positions, speed, until_contact, effort);
  }
  std::vector<double> stopped{0.6, 0.6}, asked_all;
};

std::vector<double> ends_of_shifted(double beside, ArmCycleOptions options) {
  Fakes f;
  TwoFingers hand;
  // One is stopped later, the other earlier, until the hand has followed.
  hand.stopped = {0.6 + beside / 0.1, 0.6 - beside / 0.1};
  ArmCycle cycle(options, f.arm, hand);
  cycle.start({adapting_grasp()});
  for (int i = 0; i < 4000 && !cycle.finished(); ++i) {
    f.now.time += 0.02;
    f.now.names = {"j", "f", "g"};
    f.now.positions = {f.arm.position[0], hand.stopped[0], hand.stopped[1]};
    f.now.wrist_force = Eigen::Vector3d(0, 0, hand.last_closes ? f.weight : 0);
    if (f.arm.asked.size() == 3) hand.stopped = {0.6, 0.6};
    cycle.step(f.now);
  }
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  std::vector<double> ends;
  for (const JointTrajectory& asked : f.arm.asked) ends.push_back(asked.points.back().position[0]);
  return ends;
}

TEST(ArmCycle, FollowsWhatItsFingersFeelBesideThePrediction) {
  ArmCycleOptions options;
  EXPECT_THAT(ends_of_shifted(0.01, options), ElementsAre(1, 2, 3, 4, 5, 6)) << "open loop";
  options.reacts = true;
  using ::testing::DoubleNear;
  const auto near = [](double x) { return DoubleNear(x, 1e-9); };
  EXPECT_THAT(ends_of_shifted(0.01, options),
              ElementsAre(near(1), near(2), near(2.25), near(3), near(4), near(5), near(6)));
  EXPECT_THAT(ends_of_shifted(-0.01, options)[2], near(1.75));
  EXPECT_THAT(ends_of_shifted(0.03, options)[2], near(2.5)) << "as far as the plan says it may";
  EXPECT_THAT(ends_of_shifted(0.004, options), ElementsAre(1, 2, 3, 4, 5, 6)) << "in the middle";
  options.adaptations = 0;
  EXPECT_THAT(ends_of_shifted(0.01, options), ElementsAre(1, 2, 3, 4, 5, 6));
}

// Pads that feel half a newton for each hundredth of the effort.
struct FeelingFakes : Fakes {
  void run_feeling(ArmCycle& cycle) {
    for (int i = 0; i < 4000 && !cycle.finished(); ++i) {
      const double share = hand.efforts.empty() || hand.efforts.back().empty()
                               ? 1.0
                               : hand.efforts.back().front() / 2.0;
      const double sum = hand.last_closes ? 50 * share : 0;
      if (speak) pads = {{sum, sum > 0 ? 3e-4 : 0, 0}, {sum, sum > 0 ? 3e-4 : 0, 0}, {0, 0, 0}};
      most = std::max(most, sum);
      run(cycle, 1);
    }
  }
  bool speak = true;
  double most = 0;  // N
};

ArmGrasp forceful_grasp() {
  ArmGrasp grasp = fake_grasp();
  grasp.force = 12;
  grasp.effort = 0.25;
  grasp.largest_effort = {2.0};
  grasp.contact_area = 3e-4;
  grasp.tactile_sum = 12;
  return grasp;
}

TEST(ArmCycle, PressesUntilThePadsFeelTheForceOfThePlan) {
  FeelingFakes f;
  ArmCycle cycle({}, f.arm, f.hand);
  cycle.step(f.now);
  cycle.start({forceful_grasp()});
  f.run_feeling(cycle);
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_NEAR(f.most, 12, 0.1 * 12) << "not with all that the motors can, 50 N";
  ASSERT_NE(surprise_of(cycle, SurpriseKind::kTactileSum), nullptr);
  EXPECT_FALSE(surprise_of(cycle, SurpriseKind::kTactileSum)->surprising);
  EXPECT_FALSE(surprise_of(cycle, SurpriseKind::kContactArea)->surprising);
}

TEST(ArmCycle, WhatPadsDoNotSayIsNotComparedAndTheMotorsPress) {
  FeelingFakes f;
  f.speak = false;
  ArmCycle cycle({}, f.arm, f.hand);
  cycle.step(f.now);
  cycle.start({forceful_grasp()});
  f.run_feeling(cycle);
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_NEAR(f.most, 50, 1e-9);
  EXPECT_EQ(surprise_of(cycle, SurpriseKind::kTactileSum), nullptr);
}

TEST(ArmCycle, AForceThatIsNotReachedIsASurpriseNotAFailure) {
  FeelingFakes f;
  ArmCycle cycle({}, f.arm, f.hand);
  cycle.step(f.now);
  ArmGrasp grasp = forceful_grasp();
  grasp.force = grasp.tactile_sum = 80;
  cycle.start({grasp});
  f.run_feeling(cycle);
  EXPECT_TRUE(cycle.result().success()) << cycle.result().reason;
  EXPECT_TRUE(surprise_of(cycle, SurpriseKind::kTactileSum)->surprising);
}

}  // namespace
}  // namespace prehend::control
