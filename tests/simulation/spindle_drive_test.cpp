#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "prehend/contact/grasp_stepper.h"
#include "prehend/contact/parallel_grasp.h"
#include "prehend/simulation/spindle_drive.h"

namespace prehend::simulation {
namespace {

// Two jaws of one drive round a fixed box; `opening` of the pads at the start.
struct Driven {
  SpindleDrive drive;
  contact::GraspStepper stepper;
  explicit Driven(const SpindleDriveModel& model, double opening)
      : drive(model), stepper(make(drive, opening), {}) {}

  static contact::GraspModel make(const SpindleDrive& drive, double opening) {
    contact::ParallelGraspOptions options;
    options.coupled = true;
    options.opening = opening;
    contact::GraspModel model = parallel_grasp(options);
    model.slides[0] = drive.slide();
    model.body_is_fixed = true;
    return model;
  }
  double position() const { return stepper.state().slide_position[0]; }
  double speed() const { return stepper.state().slide_velocity[0]; }
  void run(double seconds, double push = 0) {
    const double end = stepper.state().time + seconds;
    while (stepper.state().time < end - 1e-9) {
      contact::SlideCommand command = drive.drive(1e-3, position(), speed());
      command.force += push;
      stepper.system().set_command(0, command, stepper.state().time);
      stepper.step(end);
      drive.observe(1e-3, position(), speed());
      drive.observe_load(felt() - push);
    }
  }
  double felt() const { return stepper.system().pad_force(stepper.state(), 0); }
};

TEST(SpindleDrive, Pg70PressesWithThirtyNewtonsForEachAmpere) {
  const SpindleDriveModel model = pg70_drive();
  EXPECT_NEAR(model.force_per_current(), 30, 1e-9);
  for (const double current : {1.0, 2.0, 5.0}) {
    Driven grip(model, 0.0502);
    // Touch gently, then raise the current so slowly that the jaws creep in at 0.2 mm/s at most, a
    // tenth of the Stribeck velocity: friction then is stiction.
    grip.drive.command(ControlMode::kVelocity, 0.005);
    grip.run(0.05);
    for (int i = 1; i <= 2000; ++i) {
      grip.drive.command(ControlMode::kCurrent, current * i / 2000);
      grip.run(0.01);
    }
    EXPECT_NEAR(grip.felt(), 30 * current - 10, 0.1) << current;
    EXPECT_NEAR(grip.drive.current(), current, 1e-9);
    // Lowered again, stiction keeps the jaws where they are until it is overcome backwards.
    const double pressed = grip.felt();
    grip.drive.command(ControlMode::kCurrent, current - 15.0 / 30);
    grip.run(0.5);
    EXPECT_NEAR(grip.felt(), pressed, 0.05 * pressed);
  }
}

TEST(SpindleDrive, StictionHoldsBelowItsLimit) {
  Driven grip(pg70_drive(), 0.06);
  grip.drive.command(ControlMode::kCurrent, 9.5 / 30);
  grip.run(1);
  EXPECT_LT(std::abs(grip.position()), 2e-5) << "stiction is 10 N";
  grip.drive.command(ControlMode::kCurrent, 10.5 / 30);
  grip.run(0.3);
  EXPECT_GT(grip.position(), 1e-3);
}

TEST(SpindleDrive, KeepsSpeedAndAccelerationLimits) {
  Driven grip(pg70_drive(), 0.4);
  grip.drive.command(ControlMode::kVelocity, 1.0);
  for (int i = 1; i <= 600; ++i) {
    grip.run(1e-3);
    EXPECT_LT(grip.speed(), 0.0831);
    EXPECT_LT(grip.speed(), 0.32e-3 * i + 1e-4);
  }
  EXPECT_NEAR(grip.speed(), 0.083, 1e-5);
}

TEST(SpindleDrive, ReachesAPositionWithoutOvershoot) {
  Driven grip(pg70_drive(), 0.4);
  grip.drive.command(ControlMode::kPosition, 0.03);
  double farthest = 0;
  for (int i = 0; i < 200; ++i) {
    grip.run(0.01);
    farthest = std::max(farthest, grip.position());
  }
  // What the servo lets stiction keep: Fs / Ki.
  EXPECT_NEAR(grip.position(), 0.03, 10.0 / 1e6);
  EXPECT_LT(farthest, 0.03 + 10.0 / 1e6);
}

TEST(SpindleDrive, ABlockedServoPressesWithItsCurrentLimitLessStiction) {
  Driven grip(pg70_drive(), 0.0502);
  grip.drive.set_limits(1.5, 0.002);
  grip.drive.command(ControlMode::kVelocity, 0.05);
  grip.run(3);
  EXPECT_NEAR(grip.drive.current(), 1.5, 1e-9);
  EXPECT_GT(grip.felt(), 1.5 * 30 - 10 - 1e-3);
  EXPECT_LT(grip.felt(), 1.5 * 30 - 8 + 1e-3) << "it crept in at 2 mm/s at most";
  // Reversed, it lets go at once: the reference does not lead by more than the limit needs.
  grip.drive.set_limits(1.5, 0);
  grip.drive.command(ControlMode::kVelocity, -0.05);
  grip.run(0.2);
  EXPECT_EQ(grip.felt(), 0);
  EXPECT_THROW(grip.drive.set_limits(-1, 0), std::invalid_argument);
  EXPECT_THROW(grip.drive.set_limits(1, std::nan("")), std::invalid_argument);
}

TEST(SpindleDrive, IsOfItsGrippersDataSheet) {
  robot::GripperModel gripper;
  EXPECT_NEAR(drive_of(gripper, pg70_drive()).force_per_current(), 30, 1e-12);
  EXPECT_DOUBLE_EQ(drive_of(gripper, pg70_drive()).static_friction, 10);
  gripper.force_per_current = 20;
  gripper.friction_force = 4;
  gripper.max_speed = 0.05;
  const SpindleDriveModel model = drive_of(gripper, pg70_drive());
  EXPECT_NEAR(model.force_per_current(), 20, 1e-12);
  EXPECT_DOUBLE_EQ(model.coulomb_friction, 4);
  EXPECT_DOUBLE_EQ(model.static_friction, 5);
  EXPECT_DOUBLE_EQ(model.max_speed, 0.05);
  gripper.force_per_current = 50;  // beyond 0.03 N m/A without loss: 41.9 N/A
  EXPECT_THROW(drive_of(gripper, pg70_drive()), std::invalid_argument);
}

TEST(SpindleDrive, VoltageGivesTheSpeedOfBackEmf) {
  SpindleDriveModel model = pg70_drive();
  model.static_friction = model.coulomb_friction = model.viscous_friction = 0;
  Driven grip(model, 0.9);
  grip.drive.command(ControlMode::kVoltage, 12);
  grip.run(1);
  EXPECT_NEAR(grip.speed(), 12 / (model.torque_constant * model.ratio()), 1e-6);
  EXPECT_NEAR(grip.drive.current(), 0, 1e-5);
}

TEST(SpindleDrive, HeatsUpAndFallsBackTowardsNominalCurrent) {
  Driven grip(pg70_drive(), 0.0502);
  grip.drive.command(ControlMode::kCurrent, 20);
  grip.run(1);
  EXPECT_NEAR(grip.drive.current(), 6.5, 1e-9) << "cut to the peak";
  const double first = grip.drive.temperature();
  EXPECT_NEAR(first - 25, 1.5 * 6.5 * 6.5 / 20, 0.2) << "R i^2 / C";
  grip.run(599);
  // Where the heat of the limit that this temperature allows just flows away.
  const double hot = grip.drive.temperature(), limit = grip.drive.current_limit();
  EXPECT_GT(hot, 90);
  EXPECT_LT(hot, 100);
  EXPECT_NEAR(limit, 2 + 4.5 * (100 - hot) / 10, 1e-9);
  EXPECT_NEAR(hot - 25, 6 * 1.5 * (1 + 0.00393 * (hot - 25)) * limit * limit, 1);
  grip.drive.command(ControlMode::kCurrent, 0);
  grip.run(300);
  EXPECT_LT(grip.drive.temperature(), 40);
}

TEST(SpindleDrive, IsBackDrivenAboveItsFrictionOnly) {
  Driven grip(pg70_drive(), 0.2);
  grip.drive.command(ControlMode::kCurrent, 0);
  grip.run(0.5, 8);
  EXPECT_LT(std::abs(grip.position()), 2e-5);
  grip.run(0.5, 14);
  EXPECT_GT(grip.position(), 1e-3);
  SpindleDriveModel locked = pg70_drive();
  locked.efficiency = 0.4;
  EXPECT_EQ(locked.back_drive_force(), std::numeric_limits<double>::infinity());
  EXPECT_GT(pg70_drive().back_drive_force(), 10);
}

TEST(PowerScrew, ShigleysExample) {
  // Example 8-1: square thread, double-threaded, 32 mm x 4 mm, 6.4 kN, without its collar.
  const PowerScrew screw{.lead = 0.008, .mean_diameter = 0.030, .friction = 0.08};
  EXPECT_NEAR(6400 * screw.raising_torque(), 15.94, 0.005);
  EXPECT_NEAR(6400 * screw.lowering_torque(), -0.466, 0.0005);
  EXPECT_FALSE(screw.is_self_locking());
}

TEST(PowerScrew, IsAWedgeWoundUp) {
  for (const double friction : {0.0, 0.05, 0.15, 0.4}) {
    for (const double flank : {0.0, 0.26, 0.5}) {
      const PowerScrew screw{0.009, 0.010, friction, flank};
      const double lead = std::atan2(screw.lead, std::numbers::pi * screw.mean_diameter);
      const double angle = std::atan(friction / std::cos(flank));
      EXPECT_NEAR(screw.raising_torque(), 0.005 * std::tan(lead + angle), 1e-15);
      EXPECT_NEAR(screw.lowering_torque(), 0.005 * std::tan(angle - lead), 1e-15);
      EXPECT_NEAR(screw.efficiency(), std::tan(lead) / std::tan(lead + angle), 1e-12);
      EXPECT_EQ(screw.is_self_locking(), friction / std::cos(flank) > std::tan(lead));
      EXPECT_NEAR(screw.friction_along_load(), 1 - std::tan(lead - angle) / std::tan(lead), 1e-12);
    }
  }
}

// Against a load W the motor must do W / efficiency; as little as W (1 - along) holds it.
TEST(SpindleDrive, ThreadFrictionGrowsWithTheLoad) {
  SpindleDriveModel model = pg70_drive();
  model.static_friction = model.coulomb_friction = model.viscous_friction = 0;
  model.thread.emplace();
  const PowerScrew screw = model.screw();
  EXPECT_DOUBLE_EQ(screw.lead, 0.009) << "each jaw has its thread";
  for (const double load : {10.0, 40.0}) {
    const double raising = load / screw.efficiency();
    const double holding = load * (1 - screw.friction_along_load());
    ASSERT_GT(holding, 0.3 * load);
    const auto moved = [&](double force) {
      Driven jaws(model, 0.2);
      jaws.drive.observe_load(load);
      jaws.drive.command(ControlMode::kCurrent, force / model.force_per_current());
      jaws.run(0.3, -load);
      return jaws.position();
    };
    EXPECT_GT(moved(1.02 * raising), 2e-4) << load;
    EXPECT_LT(std::abs(moved(0.98 * raising)), 5e-5) << load;
    EXPECT_LT(std::abs(moved(1.02 * holding)), 5e-5) << load;
    EXPECT_LT(moved(0.98 * holding), -1e-4) << load;
    // What is over accelerates the mass, once the friction's bristle has been bent.
    EXPECT_NEAR(moved(raising + 4), 0.5 * 4 / model.reflected_mass() * 0.09, 0.03 * 0.045) << load;
  }
}

TEST(SpindleDrive, AFlatThreadLocksItself) {
  SpindleDriveModel model = pg70_drive();
  model.static_friction = model.coulomb_friction = 1;
  model.thread.emplace();
  for (const double friction : {0.25, 0.32}) {  // the tangent of the lead angle is 0.286
    model.thread->friction = friction;
    const bool locks = model.screw().is_self_locking();
    EXPECT_EQ(locks, friction > 0.286);
    Driven jaws(model, 0.2);
    jaws.drive.observe_load(100);
    jaws.drive.command(ControlMode::kCurrent, 0);
    jaws.run(0.3, -100);
    EXPECT_EQ(jaws.position() > -1e-3, locks) << jaws.position();
    EXPECT_EQ(model.back_drive_force() == std::numeric_limits<double>::infinity(), locks);
  }
  model.efficiency = 1;
  model.thread->friction = 0.1;
  const double holds = 1 - model.screw().friction_along_load();
  EXPECT_NEAR(model.back_drive_force(), 1 / holds, 1e-12) << "what gets through beats 1 N";
}

TEST(SpindleDrive, AThreadIsOfItsGrippersDataSheet) {
  SpindleDriveModel rest = pg70_drive();
  rest.thread.emplace();
  const SpindleDriveModel model = drive_of(robot::GripperModel{}, rest);
  EXPECT_NEAR(model.force_per_current() * model.screw().efficiency(), 30, 1e-12);
  rest.thread->friction = 0.2;  // leaves less than 30 N/A even with a perfect gear
  EXPECT_THROW(drive_of(robot::GripperModel{}, rest), std::invalid_argument);
}

TEST(SpindleDrive, RefusesBadConstantsByName) {
  const auto refused = [](auto change, const std::string& name) {
    SpindleDriveModel model;
    change(model);
    try {
      SpindleDrive drive(model);
      FAIL() << name << " was accepted";
    } catch (const std::invalid_argument& error) {
      EXPECT_NE(std::string(error.what()).find(name), std::string::npos) << error.what();
    }
  };
  refused([](SpindleDriveModel& m) { m.resistance = 0; }, "resistance");
  refused([](SpindleDriveModel& m) { m.thread.emplace().friction = std::nan(""); },
          "thread.friction");
  refused([](SpindleDriveModel& m) { m.thread.emplace().friction = 4; }, "thread.friction");
  refused([](SpindleDriveModel& m) { m.thread.emplace().mean_diameter = 0; },
          "thread.mean_diameter");
  refused([](SpindleDriveModel& m) { m.thread.emplace().flank_angle = 2; }, "thread.flank_angle");
  refused([](SpindleDriveModel& m) { m.efficiency = 1.2; }, "efficiency");
  refused([](SpindleDriveModel& m) { m.static_friction = 1; }, "static_friction");
  refused([](SpindleDriveModel& m) { m.peak_current = 1; }, "peak_current");
  refused([](SpindleDriveModel& m) { m.spindle_lead = std::nan(""); }, "spindle_lead");
  SpindleDrive drive(pg70_drive());
  EXPECT_THROW(drive.command(ControlMode::kCurrent, std::nan("")), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::simulation
