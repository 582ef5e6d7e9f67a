#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>

#include <gtest/gtest.h>

#include "prehend/contact/grasp_stepper.h"
#include "prehend/contact/parallel_grasp.h"
#include "prehend/simulation/spindle_drive.h"
#include "prehend/simulation/tactile_sensor.h"

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

TEST(TactileSensor, IdealPadRoundsCutsAndThresholds) {
  const TactileSensorOptions options;
  TactileSensor sensor(options);
  std::vector<double> forces(84, 0.0);
  forces[0] = 100 * options.newton_per_count;
  forces[1] = 9.6 * options.newton_per_count;
  forces[2] = 9 * options.newton_per_count;
  forces[3] = 100;
  const TactileFrameReading frame = sensor.sample(forces, 0.03);
  EXPECT_EQ(frame.counts[0], 100);
  EXPECT_EQ(frame.counts[1], 10) << "9.6 rounds to the threshold";
  EXPECT_EQ(frame.counts[2], 0) << "9 is below it";
  EXPECT_EQ(frame.counts[3], 4095);
  EXPECT_NEAR(frame.sum, options.newton_per_count * (100 + 10 + 4095), 1e-12);
}

TEST(TactileSensor, ImperfectionsAreOfTheirSize) {
  TactileSensorOptions options;
  options.gain_spread = 0.1;
  TactileSensor spread(options);
  const std::vector<double> one(84, 1000 * options.newton_per_count);
  const auto counts = spread.sample(one, 1).counts;
  const double mean = std::accumulate(counts.begin(), counts.end(), 0.0) / 84;
  double variance = 0;
  for (const auto c : counts) variance += (c - mean) * (c - mean) / 84;
  EXPECT_NEAR(mean, 1000, 40);
  EXPECT_NEAR(std::sqrt(variance), 100, 30);

  options = {};
  options.low_pass_time = 0.05;
  TactileSensor slow(options);
  EXPECT_NEAR(slow.sample(one, 0.05).counts[0], 1000 * (1 - std::exp(-1.0)), 1);

  options = {};
  options.noise = 5;
  options.dead = {7};
  TactileSensor noisy(options), same(options);
  double squares = 0;
  for (int i = 0; i < 200; ++i) {
    const auto frame = noisy.sample(one, 0.03);
    EXPECT_EQ(frame.counts, same.sample(one, 0.03).counts) << "same seed";
    EXPECT_EQ(frame.counts[7], 0);
    squares += std::pow(frame.counts[0] - 1000.0, 2) / 200;
  }
  EXPECT_NEAR(std::sqrt(squares), 5, 1);
}

// A load on one texel, shown by all: the impulse response has its width, and nothing is lost, at
// the pad's middle as at its edge.
TEST(TactileSensor, SpreadsLoadsToNeighboursWithoutLoss) {
  TactileSensorOptions options;
  options.spread = 0.004;
  options.threshold = 0;
  TactileSensor sensor(options);
  for (const int texel : {7 * 6 + 3, 0, 5}) {
    std::vector<double> forces(84, 0.0);
    forces[texel] = 2;
    const TactileFrameReading frame = sensor.sample(forces, 0.01);
    EXPECT_NEAR(frame.felt, 2, 1e-12);
    EXPECT_NEAR(frame.sum, 2, 84 * 0.5 * options.newton_per_count);
    const double ratio =
        static_cast<double>(frame.counts[texel + (texel == 5 ? -1 : 1)]) / frame.counts[texel];
    EXPECT_NEAR(ratio, std::exp(-0.5 * std::pow(0.0034 / 0.004, 2)), 2e-3);
  }
  // The variance along the rows, as far as they go.
  std::vector<double> forces(84, 0.0);
  forces[7 * 6 + 3] = 2.5;
  options.spread = 0.003;
  const auto counts = TactileSensor(options).sample(forces, 0.01).counts;
  double sum = 0, square = 0;
  for (int i = 0; i < 84; ++i) {
    sum += counts[i];
    square += counts[i] * std::pow((i / 6 - 7) * 0.0034, 2);
  }
  EXPECT_NEAR(std::sqrt(square / sum), 0.003, 5e-5);
}

TEST(TactileSensor, ShowsWhatWasALatencyAgo) {
  TactileSensorOptions options;
  options.latency = 0.025;
  options.threshold = 0;
  TactileSensor sensor(options);
  const auto ramp = [&](double t) {
    return std::vector<double>(84, 1000 * options.newton_per_count * t);
  };
  for (int i = 0; i <= 100; ++i) {
    const double t = 0.01 * i, shown = sensor.sample(ramp(t), i == 0 ? 0 : 0.01).counts[4];
    if (t > options.latency) EXPECT_NEAR(shown, 1000 * (t - options.latency), 0.51) << t;
    if (t < options.latency) EXPECT_EQ(shown, 0);
  }
}

TEST(TactileSensor, ZerosAreOffAndWander) {
  TactileSensorOptions options;
  options.offset = 20;
  options.threshold = 0;
  const std::vector<double> load(84, 1000 * options.newton_per_count);
  TactileSensor off(options);
  const auto counts = off.sample(load, 0).counts;
  EXPECT_EQ(counts, off.sample(load, 3600).counts) << "an offset stays";
  const auto deviation = [](const std::vector<std::uint16_t>& values, double mean) {
    double squares = 0;
    for (const auto c : values) squares += (c - mean) * (c - mean) / 84;
    return std::sqrt(squares);
  };
  EXPECT_NEAR(deviation(counts, 1000), 20, 6);
  options.offset = 0;
  options.drift = 20;
  TactileSensor wanders(options);
  EXPECT_EQ(wanders.sample(load, 0).counts[3], 1000);
  for (int i = 0; i < 100; ++i) wanders.sample(load, 4 * 36);
  EXPECT_NEAR(deviation(wanders.sample(load, 0).counts, 1000), 40, 12) << "4 h";
}

TEST(TactileSensor, AgesWithLoadCyclesAlone) {
  TactileSensorOptions options;
  options.ageing = 0.01;
  const std::vector<double> load(84, 1000 * options.newton_per_count), none(84, 0.0);
  TactileSensor sensor(options);
  for (int i = 0; i < 10; ++i) {
    for (int k = 0; k < 3; ++k) sensor.sample(load, 1);  // held, not pressed again
    sensor.sample(none, 1);
  }
  EXPECT_NEAR(sensor.sample(load, 1).counts[0], 1000 * std::pow(0.99, 10), 0.51);
  options.load_cycles = 50;
  EXPECT_NEAR(TactileSensor(options).sample(load, 1).counts[0], 1000 * std::pow(0.99, 50), 0.51);
}

TEST(TactileSensor, DeadRowsAndColumnsSayNothing) {
  TactileSensorOptions options;
  options.dead_rows = {2, 13};
  options.dead_columns = {5};
  options.offset = options.noise = 5;
  const auto counts = TactileSensor(options).sample(std::vector<double>(84, 0.5), 1).counts;
  for (int i = 0; i < 84; ++i) {
    const bool dead = i / 6 == 2 || i / 6 == 13 || i % 6 == 5;
    EXPECT_EQ(counts[i] == 0, dead) << i;
  }
}

TEST(TactileSensor, KeepsWhatItHasToShowStill) {
  TactileSensorOptions options = TactileSensorOptions::realistic();
  options.latency = 0.03;
  TactileSensor sensor(options), other(options);
  for (int i = 0; i < 9; ++i) sensor.sample(std::vector<double>(84, 0.1 * i), 0.01);
  StateWriter writer;
  writer(sensor);
  StateReader reader(writer.bytes(), "the sensor");
  reader(other);
  for (int i = 0; i < 9; ++i) {
    const std::vector<double> load(84, 1 - 0.1 * i);
    EXPECT_EQ(sensor.sample(load, 0.01).counts, other.sample(load, 0.01).counts);
  }
}

TEST(TactileSensor, RefusesBadInput) {
  TactileSensorOptions options;
  options.dead_rows = {14};
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument);
  options = {};
  options.gains = {1, 1};
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument);
  options = {};
  options.spread = -1;
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument);
  options = {};
  options.load_cycles = 5;
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument) << "without ageing";
  options = {};
  options.dead = {84};
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument);
  options = {};
  options.newton_per_count = 0;
  EXPECT_THROW(TactileSensor{options}, std::invalid_argument);
  TactileSensor sensor({});
  EXPECT_THROW(sensor.sample({1, 2}, 0.1), std::invalid_argument);
  EXPECT_THROW(sensor.sample(std::vector<double>(84, 1.0), -1), std::invalid_argument);
}

TEST(WrenchSensor, RoundsCutsAndIsBiased) {
  WrenchSensorOptions options;
  options.bias[2] = 0.5;
  WrenchSensor sensor(options);
  Eigen::Matrix<double, 6, 1> wrench;
  wrench << 1.234, -1000, 2, 0.12345, 0, 99;
  const auto shown = sensor.sample(wrench);
  EXPECT_NEAR(shown[0], 1.23, 1e-12);
  EXPECT_EQ(shown[1], -300);
  EXPECT_NEAR(shown[2], 2.5, 1e-12);
  EXPECT_NEAR(shown[3], 0.123, 1e-12);
  EXPECT_EQ(shown[5], 30);
  options.force_noise = 0.1;
  WrenchSensor noisy(options);
  double squares = 0;
  for (int i = 0; i < 2000; ++i) squares += std::pow(noisy.sample(wrench)[0] - 1.234, 2) / 2000;
  EXPECT_NEAR(std::sqrt(squares), 0.1, 0.01);
  options.force_range = -1;
  EXPECT_THROW(WrenchSensor{options}, std::invalid_argument);
}

}  // namespace
}  // namespace prehend::simulation
