// Continuous commands to a hand's joints: what they do, their limits, what is refused.

#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "prehend/robot/platform.h"
#include "prehend/simulation/hand_request.h"
#include "tests/simulation/flap.h"

namespace prehend::simulation {
namespace {

using robot::JointMode;
using testing::Flap;
using ::testing::HasSubstr;
using testing::joint;
using testing::run_for;

constexpr int kHinge = 0, kSlide = 1;

TEST(JointCommand, PositionGoesThereWithinSpeedAndWithoutOvershoot) {
  const Flap flap("", 4);
  for (const double step : {1e-4, 1e-3, 5e-3}) {
    RobotWorld world = flap.world(step);
    world.command_hand({JointMode::kPosition, {kHinge}, {4.0}});
    double fastest = 0, farthest = 0;
    for (int i = 0; i * step < 1; ++i) {
      world.step();
      fastest = std::max(fastest, joint(world, kHinge).velocity);
      farthest = std::max(farthest, joint(world, kHinge).position);
    }
    EXPECT_NEAR(joint(world, kHinge).position, 4, 1e-3) << step;
    EXPECT_LT(farthest, 4 + 1e-3) << step;
    EXPECT_LE(fastest, Flap::kMaxVelocity * 1.01) << step;
    EXPECT_NEAR(joint(world, kSlide).position, 0, 1e-6) << "that was not named";
  }
}

TEST(JointCommand, VelocityIsKeptCutAndEndsAtTheStop) {
  const Flap flap("", 4);
  RobotWorld world = flap.world();
  world.command_hand({JointMode::kVelocity, {kHinge, kSlide}, {3, -0.1}});
  run_for(world, 0.5);
  EXPECT_NEAR(joint(world, kHinge).velocity, 3, 0.01);
  EXPECT_NEAR(joint(world, kSlide).velocity, -0.1, 1e-3);
  world.command_hand({JointMode::kVelocity, {kSlide}, {-1e3}});
  run_for(world, 0.2);
  EXPECT_NEAR(joint(world, kSlide).velocity, -Flap::kMaxSlideVelocity, 5e-3);
  EXPECT_NEAR(joint(world, kHinge).velocity, 3, 0.01) << "goes on as it was told";
  run_for(world, 4);
  EXPECT_NEAR(joint(world, kHinge).position, 4, 1e-3);
  EXPECT_NEAR(joint(world, kSlide).position, -1, 1e-3);
  EXPECT_NEAR(joint(world, kHinge).velocity, 0, 1e-6);
}

// F = m dv/dt + c v with the mass and damping of HandMechanics.
TEST(JointCommand, EffortIsGivenAsItIs) {
  const Flap flap;
  RobotWorld world = flap.world(1e-4);
  const HandMechanics& own = world.options().mechanics;
  const double mass = own.sliding_mass + Flap::kJawMass;
  world.command_hand({JointMode::kEffort, {kSlide}, {5.0}});
  for (const double t : {0.05, 0.1, 0.3}) {
    run_for(world, t - world.time());
    const double v = 5 / own.sliding_damping * (1 - std::exp(-own.sliding_damping * t / mass));
    EXPECT_NEAR(joint(world, kSlide).velocity, v, 1e-3 * v);
    EXPECT_NEAR(joint(world, kSlide).effort, 5, 1e-9);
  }
}

TEST(JointCommand, EffortKeepsEffortSpeedAndStop) {
  for (const double step : {1e-4, 1e-3, 5e-3}) {
    const Flap flap;
    RobotWorld world = flap.world(step);
    world.command_hand({JointMode::kEffort, {kSlide}, {-1e9}});
    double fastest = 0;
    for (int i = 0; i * step < 4; ++i) {
      world.step();
      fastest = std::max(fastest, -joint(world, kSlide).velocity);
      ASSERT_LE(std::abs(joint(world, kSlide).effort), Flap::kMaxForce * (1 + 1e-9));
      ASSERT_GE(joint(world, kSlide).position, -1 - 1e-4);
    }
    EXPECT_LE(fastest, Flap::kMaxSlideVelocity * 1.001) << step;
    EXPECT_GE(fastest, Flap::kMaxSlideVelocity * 0.99) << step;
    EXPECT_NEAR(joint(world, kSlide).position, -1, 2e-3) << step;
  }
}

TEST(JointCommand, StopBrakesAndHolds) {
  const Flap flap;
  for (const JointMode mode : {JointMode::kVelocity, JointMode::kEffort}) {
    RobotWorld world = flap.world();
    world.command_hand({mode, {kSlide}, {mode == JointMode::kVelocity ? 0.3 : 30.0}});
    run_for(world, 0.15);
    const double v = joint(world, kSlide).velocity, at = joint(world, kSlide).position;
    ASSERT_GT(v, 0.2);
    world.command_hand({JointMode::kStop, {kSlide}, {}});
    run_for(world, 0.3);
    EXPECT_NEAR(joint(world, kSlide).velocity, 0, 1e-4);
    // Within its acceleration of max_velocity / ramp = 5 m/s^2 and the loop's lag.
    EXPECT_NEAR(joint(world, kSlide).position, at + v * v / 10, 5e-3);
  }
}

TEST(JointCommand, OnlyWhatMovesIsStoppedWhenTheStreamEnds) {
  const Flap flap;
  RobotWorld world = flap.world();
  EXPECT_FALSE(world.stop_commanded_hand()) << "nothing was commanded";
  world.command_hand({JointMode::kVelocity, {kHinge}, {2}});
  EXPECT_FALSE(world.stop_commanded_hand()) << "it stands";
  run_for(world, 0.2);
  EXPECT_TRUE(world.stop_commanded_hand());
  EXPECT_FALSE(world.stop_commanded_hand()) << "it stops already";
  run_for(world, 0.5);
  EXPECT_NEAR(joint(world, kHinge).velocity, 0, 1e-4);
}

TEST(JointCommand, ABlockedJointPressesAndIsReversedAtOnce) {
  const Flap flap;
  RobotWorld world = flap.world();
  world.add_object(
      "wall",
      geometry::transformed(geometry::make_box({0.1, 1, 2.6}),
                            geometry::RigidTransform(Eigen::Translation3d(0.2, 0, 1.3))),
      1, true);
  world.command_hand({JointMode::kVelocity, {kSlide}, {0.1}});
  run_for(world, 3);
  EXPECT_NEAR(joint(world, kSlide).effort, Flap::kMaxForce, 0.5) << "its greatest, and no more";
  const double at = joint(world, kSlide).position;
  world.command_hand({JointMode::kEffort, {kSlide}, {20}});
  run_for(world, 0.5);
  EXPECT_NEAR(joint(world, kSlide).effort, 20, 0.1);
  EXPECT_FALSE(world.stop_commanded_hand()) << "it presses, and stands";
  world.command_hand({JointMode::kStop, {kSlide}, {}});
  run_for(world, 0.5);
  EXPECT_NEAR(joint(world, kSlide).effort, 20, 2) << "holds with what was there";
  world.command_hand({JointMode::kVelocity, {kSlide}, {-0.1}});
  run_for(world, 0.2);
  EXPECT_LT(joint(world, kSlide).position, at - 0.01);
}

TEST(JointCommand, AMotionTakesOverFromWhereItIs) {
  const Flap flap;
  RobotWorld world = flap.world();
  world.command_hand({JointMode::kVelocity, {kHinge}, {2}});
  run_for(world, 0.5);
  HandCommand back;
  back.position = Eigen::Vector2d(0.3, 0);
  world.move_hand(back);
  run_for(world, 2);
  EXPECT_TRUE(world.hand().reached());
  EXPECT_NEAR(joint(world, kHinge).position, 0.3, 1e-3);
  // And a command ends a motion: those that are not named hold where they are.
  back.position = Eigen::Vector2d(0.3, 0.5);
  back.speed = 0.2;
  world.move_hand(back);
  run_for(world, 0.5);
  const double at = joint(world, kSlide).position;
  ASSERT_GT(at, 0.01);
  world.command_hand({JointMode::kPosition, {kHinge}, {0.4}});
  run_for(world, 1);
  EXPECT_NEAR(joint(world, kSlide).position, at, 5e-3);
  EXPECT_NEAR(joint(world, kHinge).position, 0.4, 1e-3);
}

TEST(JointCommand, StatesGoOnBitwise) {
  const Flap flap(
      "motor: {hinge: {supply: 12, resistance: 2, torque_constant: 0.02, gear_ratio: 50, "
      "rotor_inertia: 1e-6, nominal_current: 1.8}}\n");
  RobotWorld world = flap.world();
  world.command_hand({JointMode::kVoltage, {kHinge}, {5}});
  world.command_hand({JointMode::kVelocity, {kSlide}, {0.2}});
  run_for(world, 0.01);
  const auto saved = world.save();
  run_for(world, 0.05);
  const JointReading hinge = joint(world, kHinge), slide = joint(world, kSlide);
  const double current = world.hand().current(kHinge);
  world.stop_hand();
  run_for(world, 0.1);
  world.restore(*saved);
  run_for(world, 0.05);
  EXPECT_EQ(joint(world, kHinge).position, hinge.position);
  EXPECT_EQ(joint(world, kHinge).velocity, hinge.velocity);
  EXPECT_EQ(joint(world, kSlide).position, slide.position);
  EXPECT_EQ(world.hand().current(kHinge), current);
}

// The inner link of a Barrett's finger is held by a worm, which its motor alone turns back.
TEST(JointCommand, ABarrettsFingerClosesAndOpens) {
  geometry::RigidTransform X_WH = geometry::RigidTransform::Identity();
  X_WH.translation().z() = 1;
  RobotWorld world(robot::read_hand_model("config/robots/bh8.yaml"), X_WH);
  const int finger = world.hand_model().actuated_index("finger_2_inner");
  for (const JointMode mode : {JointMode::kPosition, JointMode::kVelocity, JointMode::kEffort}) {
    world.command_hand({JointMode::kPosition, {finger}, {1.0}});
    run_for(world, 3);
    EXPECT_NEAR(world.hand_positions()[finger], 1.0, 0.02);
    const double value = mode == JointMode::kPosition   ? 0.3
                         : mode == JointMode::kVelocity ? -0.4
                                                        : -0.5;
    world.command_hand({mode, {finger}, {value}});
    run_for(world, 2);
    EXPECT_LT(world.hand_positions()[finger], 0.6) << static_cast<int>(mode);
  }
}

class RefusedJointCommand : public ::testing::Test {
 protected:
  RefusedJointCommand() : world_(flap_.world()) {}

  std::string refusal(const JointsRequest& request) {
    try {
      world_.command_hand(check_joints_request(world_, request));
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "";
  }

  const Flap flap_{"", 4};
  RobotWorld world_;
};

TEST_F(RefusedJointCommand, SaysWhyAndNothingMoves) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  const struct {
    JointsRequest request;
    const char* words;
  } bad[] = {
      {{JointMode::kVelocity, {}, {}}, "names no joint"},
      {{JointMode::kVelocity, {"hinge"}, {}}, "0 values for 1 joints"},
      {{JointMode::kVelocity, {"hinge"}, {1, 2}}, "2 values for 1 joints"},
      {{JointMode::kVelocity, {"hing"}, {1}},
       "the hand has no motor 'hing'; did you mean \"hinge\"?"},
      {{JointMode::kVelocity, {"hinge", "hinge"}, {1, 1}}, "joint 'hinge' is named twice"},
      {{JointMode::kPosition, {"slide", "hinge"}, {0.1, 4.1}}, "'hinge' at 4.1000 is outside"},
      {{JointMode::kPosition, {"slide", "hinge"}, {0.1, nan}}, "'hinge' is not finite"},
      {{JointMode::kVelocity, {"slide", "hinge"}, {0.1, infinity}}, "'hinge' is not finite"},
      {{JointMode::kEffort, {"slide", "hinge"}, {0.1, nan}}, "'hinge' is not finite"},
      {{JointMode::kVoltage, {"slide"}, {1}}, "'slide' has no motor"},
      {{JointMode::kStop, {"slide"}, {1}}, "values for joints that are to stop"},
  };
  for (const auto& one : bad) EXPECT_THAT(refusal(one.request), HasSubstr(one.words));
  run_for(world_, 0.5);
  EXPECT_EQ(joint(world_, kSlide).position, 0);
  EXPECT_EQ(joint(world_, kHinge).position, 0);
  EXPECT_EQ(refusal({JointMode::kStop, {}, {}}), "") << "all of them";
}

TEST_F(RefusedJointCommand, LeavesARunningCommandAsItIs) {
  ASSERT_EQ(refusal({JointMode::kVelocity, {"slide"}, {0.2}}), "");
  run_for(world_, 0.3);
  EXPECT_NE(refusal({JointMode::kPosition, {"slide"}, {7}}), "");
  run_for(world_, 0.3);
  EXPECT_NEAR(joint(world_, kSlide).velocity, 0.2, 1e-3);
}

}  // namespace
}  // namespace prehend::simulation
