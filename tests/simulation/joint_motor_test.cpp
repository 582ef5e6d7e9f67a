// The DC motor at a joint against closed forms.

#include <cmath>
#include <numbers>
#include <string>

#include <gtest/gtest.h>

#include "tests/simulation/flap.h"

namespace prehend::simulation {
namespace {

using robot::JointMode;
using testing::Flap;
using testing::joint;
using testing::run_for;

// K = 1 N m/A, emf = 1 V s/rad, reflected inertia 2.5e-3 kg m^2.
constexpr double kSupply = 12, kResistance = 2, kReflected = 2.5e-3, kCurrent = 1.8;
constexpr double kInertia = Flap::kFlapInertia + kReflected;
constexpr double kTimeConstant = kInertia * kResistance;

std::string hinge_motor(const std::string& more = "") {
  return "motor: {hinge: {supply: 12, resistance: 2, torque_constant: 0.02, gear_ratio: 50, "
         "rotor_inertia: 1e-6, nominal_current: 1.8" +
         more + "}}\n";
}

void give_voltage(RobotWorld& world, double voltage, int motor = 0) {
  world.command_hand({JointMode::kVoltage, {motor}, {voltage}});
}

TEST(JointMotor, SpeedRisesToThatOfBackEmfWithTheMechanicalTimeConstant) {
  const Flap flap(hinge_motor());
  for (const double voltage : {-3.0, 1.0, 3.0}) {
    RobotWorld world = flap.world(1e-5);
    give_voltage(world, voltage);
    for (const double t : {0.5, 1.0, 2.0}) {
      run_for(world, t * kTimeConstant - world.time());
      EXPECT_NEAR(joint(world, 0).velocity, voltage * (1 - std::exp(-t)), 2e-3 * std::abs(voltage));
    }
    run_for(world, 20 * kTimeConstant);
    EXPECT_NEAR(joint(world, 0).velocity, voltage, 1e-4) << "V / emf";
    EXPECT_NEAR(world.hand().current(0), 0, 1e-4);
  }
}

TEST(JointMotor, FrictionTakesItsPartOfTheSpeed) {
  const Flap flap(hinge_motor(", friction: 0.3, viscous_friction: 0.05, efficiency: 0.8"));
  RobotWorld world = flap.world();
  give_voltage(world, 4);
  run_for(world, 0.3);
  // eta K (V - emf v) / R = 0.3 + 0.05 v
  const double v = (0.8 * 4 / kResistance - 0.3) / (0.8 / kResistance + 0.05);
  EXPECT_NEAR(joint(world, 0).velocity, v, 1e-3 * v);
  EXPECT_NEAR(world.hand().current(0), (4 - v) / kResistance, 1e-3);
  EXPECT_NEAR(joint(world, 0).effort, 0.3 + 0.05 * v, 1e-3);
}

TEST(JointMotor, StalledItGivesWhatTheVoltageAloneDrives) {
  const Flap flap(hinge_motor(", friction: 1.9"));
  for (const double voltage : {1.0, 2.0, 3.0, 12.0}) {
    RobotWorld world = flap.world();
    give_voltage(world, voltage);
    run_for(world, 0.2);
    const double current = std::min(voltage / kResistance, kCurrent);
    EXPECT_NEAR(joint(world, 0).position, 0, 1e-4) << voltage << ": friction holds it";
    EXPECT_NEAR(joint(world, 0).effort, current, 1e-3) << voltage;
    EXPECT_NEAR(world.hand().current(0), current, 1e-3) << voltage;
  }
}

// Electric work = heat of the winding + kinetic energy, at each instant.
TEST(JointMotor, KeepsTheBalanceOfEnergy) {
  const Flap flap(hinge_motor());
  const double h = 1e-5, voltage = 3;
  RobotWorld world = flap.world(h);
  give_voltage(world, voltage);
  double work = 0, heat = 0;
  for (int i = 0; i < 3000; ++i) {
    world.step();
    const double i_now = world.hand().current(0);
    work += h * voltage * i_now;
    heat += h * kResistance * i_now * i_now;
    if (i % 500 != 499) continue;
    const double v = joint(world, 0).velocity;
    EXPECT_NEAR(work, heat + 0.5 * kInertia * v * v, 2e-3 * work);
  }
}

TEST(JointMotor, AtAnyStepItNeverRunsAwayNorSwings) {
  const Flap flap(hinge_motor());
  for (const double step : {1e-5, 1e-4, 1e-3, 1e-2, 5e-2}) {
    RobotWorld world = flap.world(step);
    give_voltage(world, 3);
    double before = 0;
    for (int i = 0; i * step < 0.5 || i < 10; ++i) {
      world.step();
      const double v = joint(world, 0).velocity;
      EXPECT_GE(v, before - 1e-9) << step;
      EXPECT_LE(v, 3 * (1 + 1e-9)) << step;
      before = v;
    }
    EXPECT_NEAR(before, 3, 0.01) << step;
  }
}

TEST(JointMotor, VoltageKeepsSupplyCurrentSpeedAndStop) {
  for (const double step : {1e-4, 1e-3, 5e-3}) {
    const Flap flap(hinge_motor(), 3);
    RobotWorld world = flap.world(step);
    give_voltage(world, 1e6);
    double fastest = 0;
    for (int i = 0; i * step < 2; ++i) {
      world.step();
      fastest = std::max(fastest, joint(world, 0).velocity);
      ASSERT_LE(std::abs(world.hand().current(0)), kCurrent * 1.001) << step;
      ASSERT_LE(joint(world, 0).position, 3 + 1e-3) << step;
    }
    EXPECT_LE(fastest, kSupply) << "the supply's back-EMF";
    EXPECT_GT(fastest, 0.8 * kSupply);
    EXPECT_NEAR(joint(world, 0).position, 3, 0.02) << step;
    EXPECT_NEAR(joint(world, 0).velocity, 0, 1e-3) << step;
  }
  // A motor that could run faster than its joint may.
  const Flap fast(
      "motor: {hinge: {supply: 60, resistance: 2, torque_constant: 0.02, gear_ratio: 50, "
      "rotor_inertia: 1e-6, nominal_current: 1.8}}\n");
  RobotWorld world = fast.world();
  give_voltage(world, 60);
  double fastest = 0;
  for (int i = 0; i < 2000; ++i) {
    world.step();
    fastest = std::max(fastest, joint(world, 0).velocity);
  }
  EXPECT_LE(fastest, Flap::kMaxVelocity * 1.001);
  EXPECT_NEAR(joint(world, 0).velocity, Flap::kMaxVelocity, 0.05);
}

TEST(JointMotor, EffortGoesToTheMotorAsItsCurrent) {
  const Flap flap(hinge_motor());
  RobotWorld world = flap.world(1e-4);
  world.command_hand({JointMode::kEffort, {0}, {0.5}});
  run_for(world, 0.02);
  EXPECT_NEAR(joint(world, 0).velocity, 0.5 * 0.02 / kInertia, 1e-3);
  EXPECT_NEAR(world.hand().current(0), 0.5, 1e-9);
  // At 8 rad/s its back-EMF leaves (12 - v) / R: the supply's speed is not passed.
  run_for(world, 0.5);
  EXPECT_NEAR(joint(world, 0).velocity, kSupply, 0.01);
}

TEST(JointMotor, PositionsGoThroughTheMotorToo) {
  const Flap flap(hinge_motor());
  RobotWorld world = flap.world();
  HandCommand command;
  command.position = Eigen::Vector2d(1.2, 0.1);
  command.speed = 0.5;
  world.move_hand(command);
  double most = 0;
  for (int i = 0; i < 1500; ++i) {
    world.step();
    most = std::max(most, std::abs(world.hand().current(0)));
  }
  EXPECT_TRUE(world.hand().reached());
  EXPECT_NEAR(joint(world, 0).position, 1.2, 2e-3);
  EXPECT_NEAR(joint(world, 1).position, 0.1, 1e-3);
  EXPECT_GT(most, 0.05);
  EXPECT_LE(most, kCurrent * 1.001);
  EXPECT_TRUE(std::isnan(world.hand().current(1))) << "the slide has no motor";
}

TEST(JointMotor, ASpindleMovesAJointThatSlides) {
  // 2 pi 4 / 9 mm = 2793 rad/m, K = 83.8 N/A, emf 83.8 V s/m.
  const Flap flap(
      "motor: {slide: {supply: 24, resistance: 1.5, torque_constant: 0.03, gear_ratio: 4, "
      "spindle_lead: 0.009, rotor_inertia: 2e-6, nominal_current: 1}}\n");
  RobotWorld world = flap.world();
  give_voltage(world, 6, 1);
  run_for(world, 0.5);
  const double emf = 0.03 * 2 * std::numbers::pi * 4 / 0.009;
  EXPECT_NEAR(joint(world, 1).velocity, 6 / emf, 1e-5);
}

TEST(JointMotor, HeatLowersTheCurrentToTheNominal) {
  const Flap flap(
      hinge_motor(", peak_current: 1.85, friction: 1.99, thermal_resistance: 20, "
                  "thermal_capacity: 0.1, hottest: 90"));
  const Flap cold(hinge_motor(", peak_current: 1.85, friction: 1.99"));
  RobotWorld world = flap.world(), other = cold.world();
  for (RobotWorld* w : {&world, &other}) {
    give_voltage(*w, 12);
    run_for(*w, 20);
  }
  EXPECT_NEAR(world.hand().current(0), 1.8, 0.01)
      << "2 Ohm of 1.8 A at 20 K/W are beyond 90 degrees";
  EXPECT_NEAR(other.hand().current(0), 1.85, 1e-3);
}

}  // namespace
}  // namespace prehend::simulation
