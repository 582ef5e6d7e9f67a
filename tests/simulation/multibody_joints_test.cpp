// Stops, friction, damping, drives and clutches of joints, and bodies on prescribed paths, against
// closed forms.

#include <cmath>
#include <cstdlib>
#include <limits>
#include <new>

#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "tests/simulation/engine_scenes.h"

namespace {
bool counting = false;
std::size_t allocations = 0;
}  // namespace

[[gnu::noinline]] void* operator new(std::size_t size) {
  if (counting) ++allocations;
  if (void* memory = std::malloc(size)) return memory;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* memory) noexcept { std::free(memory); }
[[gnu::noinline]] void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }

namespace prehend::simulation::engines {
namespace {

constexpr double kInertia = 2e-3;  // kg m^2, of a wheel about its axle

/// A chain-free set of wheels on axles along y, all at the world's origin and passing through each
/// other.
EngineScene wheels(int count) {
  EngineScene scene;
  scene.gravity.setZero();
  for (int i = 0; i < count; ++i) {
    scene.bodies.push_back(box(1, {0.1, 0.1, 0.1}, Eigen::Vector3d::Zero()));
    scene.bodies.back().moments.setConstant(kInertia);
    scene.bodies.back().collides = false;
    scene.joints.push_back(hinge(-1, i, Eigen::Vector3d::Zero()));
  }
  return scene;
}

struct Rig {
  explicit Rig(const EngineScene& scene, double step = 1e-3)
      : h(step), system((validate(scene), scene)), state(system.initial_state()) {}
  void step() {
    system.implicit_euler(state, h, state, next);
    std::swap(state, next);
  }
  void run(double seconds) {
    for (long i = std::lround(seconds / h); i > 0; --i) step();
  }
  double h;
  Multibody system;
  MultibodyState state, next;
};

EngineScene pendulum(double angle) {
  EngineScene scene;
  scene.bodies = {box(0.2, {0.02, 0.02, 0.02}, {0.5 * std::sin(angle), 0, -0.5 * std::cos(angle)})};
  scene.bodies[0].collides = false;
  scene.joints = {hinge(-1, 0, Eigen::Vector3d::Zero())};
  return scene;
}

TEST(MultibodyJoints, DampedPendulumDecaysAsItsEquationSays) {
  Rig pendulum_run(pendulum(0.02), 2e-5);
  JointMechanics mechanics;
  mechanics.damping = 0.02;
  pendulum_run.system.set_mechanics(0, mechanics);
  const double inertia = 0.2 * 0.25 + 0.2 / 6 * 4e-4, k = 0.2 * 9.81 * 0.5;
  const double decay = mechanics.damping / (2 * inertia);
  const double frequency = std::sqrt(k / inertia - decay * decay);
  for (int i = 0; i < 4; ++i) {
    pendulum_run.run(0.25);
    const double t = pendulum_run.state.time;
    // The position counts from the start; 0.02 rad are small enough for the linear equation.
    const double angle = 0.02 * std::exp(-decay * t) *
                         (std::cos(frequency * t) + decay / frequency * std::sin(frequency * t));
    EXPECT_NEAR(std::abs(pendulum_run.system.joint_position(pendulum_run.state, 0)),
                std::abs(angle - 0.02), 2e-5);
  }
}

TEST(MultibodyJoints, RotorsAddTheirInertia) {
  Rig wheel(wheels(1));
  JointMechanics mechanics;
  mechanics.rotor_inertia = 3 * kInertia;
  wheel.system.set_mechanics(0, mechanics);
  wheel.system.set_joint_force(0, 0.04);
  wheel.run(0.5);
  EXPECT_NEAR(wheel.state.velocities[0], 0.04 * 0.5 / (4 * kInertia), 1e-9);
  EXPECT_NEAR(wheel.system.energy(wheel.state),
              0.5 * 4 * kInertia * std::pow(wheel.state.velocities[0], 2), 1e-12);
}

// Backward Euler of I x'' = -d x' + c (1 - x): within its first-order error of the closed form.
TEST(MultibodyJoints, PositionDriveHasItsStepResponse) {
  for (const double h : {1e-3, 1e-4}) {
    Rig wheel(wheels(1), h);
    JointDrive drive;
    drive.mode = JointDrive::Mode::kPosition;
    drive.target = 0.3;
    drive.stiffness = 0.8;
    drive.damping = 0.04;
    wheel.system.set_drive(0, drive);
    const double decay = drive.damping / (2 * kInertia);
    const double frequency = std::sqrt(drive.stiffness / kInertia - decay * decay);
    double worst = 0;
    for (int i = 0; i < 10; ++i) {
      wheel.run(0.05);
      const double t = wheel.state.time;
      const double x =
          0.3 * (1 - std::exp(-decay * t) *
                         (std::cos(frequency * t) + decay / frequency * std::sin(frequency * t)));
      worst = std::max(worst, std::abs(wheel.state.positions[0] - x));
    }
    EXPECT_LT(worst, 3 * h) << "first order in h";
    EXPECT_NEAR(wheel.system.drive_force(0), 0, 3e-3);
  }
}

TEST(MultibodyJoints, DrivesAreStableForAnyStiffnessAndNeverExceedTheirLimit) {
  for (const double stiffness : {1.0, 1e4, 1e9}) {
    for (const double h : {1e-4, 1e-2}) {
      Rig wheel(wheels(1), h);
      JointDrive drive;
      drive.mode = JointDrive::Mode::kPosition;
      drive.target = 1;
      drive.stiffness = stiffness;
      drive.damping = 2 * std::sqrt(stiffness * kInertia);
      drive.limit = 0.05;
      wheel.system.set_drive(0, drive);
      for (int i = 0; i < std::lround(2 / h); ++i) {
        wheel.step();
        ASSERT_LE(std::abs(wheel.system.drive_force(0)), drive.limit * (1 + 1e-12));
        // At the limit of its force all the way it would swing to twice the target.
        ASSERT_LT(std::abs(wheel.state.positions[0]), 2.01) << stiffness << ' ' << h << ' ' << i;
      }
      // Far stiffer ones swing between their limits.
      if (stiffness == 1) {
        EXPECT_NEAR(wheel.state.positions[0], 1, 0.02) << h;
      }
    }
  }
}

TEST(MultibodyJoints, VelocityDriveCarriesAsMuchAsItsLimit) {
  for (const double load : {0.03, 0.07}) {
    Rig wheel(wheels(1));
    JointDrive drive;
    drive.mode = JointDrive::Mode::kVelocity;
    drive.target = 2;
    drive.damping = 10;
    drive.limit = 0.05;
    wheel.system.set_drive(0, drive);
    wheel.system.set_joint_force(0, -load);
    wheel.run(0.4);
    if (load < drive.limit) {
      EXPECT_NEAR(wheel.state.velocities[0], 2 - load / drive.damping, 1e-9);
      EXPECT_NEAR(wheel.system.drive_force(0), load, 1e-9);
    } else {
      EXPECT_NEAR(wheel.state.velocities[0], (drive.limit - load) * 0.4 / kInertia, 1e-6);
      EXPECT_NEAR(wheel.system.drive_force(0), drive.limit, 1e-12);
    }
  }
}

TEST(MultibodyJoints, StopsTakeEnergyAndHold) {
  for (const double h : {1e-4, 1e-2}) {
    EngineScene scene = wheels(1);
    scene.bodies[0].angular_velocity.y() = 7;
    Rig wheel(scene, h);
    JointMechanics mechanics;
    mechanics.lower = -0.3;
    mechanics.upper = 0.5;
    wheel.system.set_mechanics(0, mechanics);
    double energy = wheel.system.energy(wheel.state);
    for (int i = 0; i < std::lround(1 / h); ++i) {
      wheel.step();
      ASSERT_LE(wheel.system.energy(wheel.state), energy * (1 + 1e-9) + 1e-12);
      energy = wheel.system.energy(wheel.state);
      ASSERT_LE(wheel.state.positions[0], 0.5 + 1e-6);
    }
    EXPECT_NEAR(wheel.state.positions[0], 0.5, 1e-5) << "inelastic";
    // Pressed on, it holds; drawn back, it lets go at once and holds at the other end.
    wheel.system.set_joint_force(0, 100);
    wheel.run(1);
    EXPECT_NEAR(wheel.state.positions[0], 0.5, 1e-4);
    wheel.system.set_joint_force(0, -0.01);
    wheel.run(1);
    EXPECT_NEAR(wheel.state.positions[0], -0.3, 1e-5);
  }
}

TEST(MultibodyJoints, DryFrictionSticksAndBrakes) {
  EngineScene scene = wheels(2);
  scene.bodies[1].angular_velocity.y() = 3;
  Rig pair(scene);
  JointMechanics mechanics;
  mechanics.dry_friction = 0.02;
  pair.system.set_mechanics(0, mechanics);
  pair.system.set_mechanics(1, mechanics);
  pair.system.set_joint_force(0, 0.0199);
  const double stops_after = 3 * kInertia / 0.02;
  pair.run(0.5 * stops_after);
  EXPECT_NEAR(pair.state.velocities[1], 1.5, 1e-9);
  pair.run(2 * stops_after);
  EXPECT_NEAR(pair.state.velocities[1], 0, 1e-12);
  EXPECT_NEAR(pair.state.positions[1], 0.5 * 3 * stops_after, 3 * 1e-3) << "first order";
  EXPECT_LT(std::abs(pair.state.positions[0]), 1e-6) << "it sticks";
  pair.system.set_joint_force(0, 0.03);
  const double from = pair.state.velocities[0];
  pair.run(0.2);
  EXPECT_NEAR(pair.state.velocities[0] - from, 0.01 * 0.2 / kInertia, 1e-6);
}

TEST(MultibodyJoints, ClutchKeepsTheRatioUntilItBreaksAway) {
  // Coordinate 1 is the outer link with the motor, coordinate 0 the inner one: three times as fast.
  Rig finger(wheels(2));
  finger.system.add_coupling({0, 1, 3, 0.05});
  JointDrive drive;
  drive.mode = JointDrive::Mode::kVelocity;
  drive.target = 0.2;
  drive.damping = 10;
  drive.limit = 0.04;  // so that the clutch bears what speeds up the inner link
  finger.system.set_drive(1, drive);
  finger.run(1);
  EXPECT_NEAR(finger.state.positions[1], 0.2 * (1 - 0.5 * 0.2 * 10 * kInertia / 0.04), 1e-3);
  EXPECT_NEAR(finger.state.positions[0], 3 * finger.state.positions[1], 1e-6);
  // The inner link is stopped: the outer goes on, and the inner presses with the breakaway torque.
  JointMechanics stopped;
  stopped.upper = finger.state.positions[0] + 0.01;
  finger.system.set_mechanics(0, stopped);
  drive.limit = 0.3;
  finger.system.set_drive(1, drive);
  const double outer_before = finger.state.positions[1];
  finger.run(1);
  EXPECT_NEAR(finger.state.positions[0], stopped.upper, 1e-6);
  EXPECT_NEAR(finger.state.positions[1], outer_before + 0.2 - 3 * 0.05 / drive.damping, 2e-3);
  EXPECT_NEAR(finger.system.drive_force(1), 3 * 0.05, 1e-6) << "at the outer: ratio times it";
  // Back: both move in their ratio again.
  drive.target = -0.2;
  drive.limit = 0.04;
  finger.system.set_drive(1, drive);
  finger.run(0.2);
  const double inner = finger.state.positions[0], outer = finger.state.positions[1];
  finger.run(0.2);
  EXPECT_NEAR(finger.state.positions[0] - inner, 3 * (finger.state.positions[1] - outer), 1e-6);
}

TEST(MultibodyJoints, OneDriveMovesTwoJointsByTheirSum) {
  Rig finger(wheels(2));
  JointDrive drive;
  drive.mode = JointDrive::Mode::kPosition;
  drive.target = 0.6;
  drive.stiffness = 1;
  drive.damping = 0.03;
  drive.along = 1;
  drive.share = 0.5;
  finger.system.set_drive(0, drive);
  finger.run(2);
  const Eigen::VectorXd& q = finger.state.positions;
  EXPECT_NEAR(q[0] + 0.5 * q[1], 0.6, 1e-6);
  EXPECT_NEAR(q[1], 0.5 * q[0], 1e-6) << "equal inertias share the torque as the gear does";
}

TEST(MultibodyJoints, WhatStandsOnAPrescribedBodyRidesWithIt) {
  EngineScene scene;
  scene.bodies = {box(1, {0.4, 0.4, 0.02}, {0, 0, -0.01}),
                  box(0.3, {0.05, 0.05, 0.05}, {0.1, 0, 0.025})};
  scene.bodies[0].is_fixed = true;
  Rig table(scene);
  const double rate = 1.2;  // rad/s; at 0.1 m: 0.14 m/s^2, far from slipping
  geometry::RigidTransform X = scene.bodies[0].X_WB;
  double angle = 0;
  for (int i = 0; i < 1500; ++i) {
    angle += table.h * std::min(rate, 0.004 * i);
    X.linear() = Eigen::AngleAxisd(angle, Eigen::Vector3d::UnitZ()).toRotationMatrix();
    X.translation().z() = -0.01 + 0.05 * (1 - std::cos(2e-3 * i));
    table.system.prescribe(0, X);
    table.step();
  }
  const Eigen::Vector3d p = X.inverse() * table.state.X_WB[1].translation();
  EXPECT_NEAR((p - Eigen::Vector3d(0.1, 0, 0.035)).norm(), 0, 1e-4);
}

TEST(MultibodyJoints, SleepersStayAndBear) {
  EngineScene scene;
  scene.bodies = {box(0.3, {0.1, 0.1, 0.1}, {0, 0, 0.05}),
                  box(0.2, {0.05, 0.05, 0.05}, {0, 0, 0.13})};
  Rig pair(scene);
  pair.system.set_asleep(0, true);
  pair.run(0.6);
  EXPECT_EQ(pair.state.X_WB[0].translation(), scene.bodies[0].X_WB.translation());
  EXPECT_NEAR(pair.state.X_WB[1].translation().z(), 0.125, 1e-4);
  pair.system.set_asleep(0, false);  // nothing is below it
  pair.run(0.1);
  EXPECT_LT(pair.state.X_WB[0].translation().z(), 0.05 - 0.045);
}

TEST(MultibodyJoints, AStepAllocatesNothing) {
  EngineScene scene = pressed_cube(false);
  scene.ground = true;
  scene.bodies.push_back(body_of(EngineShape::Kind::kCylinder, 0.2, {0.2, 0, 0.03}));
  Rig held(scene);
  JointMechanics mechanics;
  mechanics.upper = 0.03;
  mechanics.dry_friction = 0.1;
  held.system.set_mechanics(0, mechanics);
  JointDrive drive;
  drive.mode = JointDrive::Mode::kPosition;
  drive.target = 0.01;
  drive.stiffness = 1e3;
  drive.limit = 5;
  held.system.set_drive(0, drive);
  held.system.set_joint_force(1, 5);
  held.run(0.05);
  allocations = 0;
  counting = true;
  held.run(0.05);
  counting = false;
  EXPECT_EQ(allocations, 0u);
}

TEST(MultibodyJoints, RefusesWhatMakesNoSense) {
  Rig pair(wheels(2));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  JointMechanics mechanics;
  mechanics.lower = 1;
  mechanics.upper = 0;
  EXPECT_THROW(pair.system.set_mechanics(0, mechanics), std::invalid_argument);
  mechanics = {};
  mechanics.damping = -1;
  EXPECT_THROW(pair.system.set_mechanics(0, mechanics), std::invalid_argument);
  mechanics = {};
  mechanics.dry_friction = nan;
  EXPECT_THROW(pair.system.set_mechanics(0, mechanics), std::invalid_argument);
  JointDrive drive;
  drive.target = nan;
  EXPECT_THROW(pair.system.set_drive(0, drive), std::invalid_argument);
  drive = {};
  drive.limit = nan;
  EXPECT_THROW(pair.system.set_drive(0, drive), std::invalid_argument);
  EXPECT_THROW(pair.system.set_drive(2, {}), std::out_of_range);
  EXPECT_THROW(pair.system.add_coupling({0, 0, 1, 1}), std::invalid_argument);
  EXPECT_THROW(pair.system.add_coupling({0, 2, 1, 1}), std::invalid_argument);
  EXPECT_THROW(pair.system.add_coupling({0, 1, 1, 0}), std::invalid_argument);
  EXPECT_THROW(pair.system.prescribe(0, geometry::RigidTransform::Identity()),
               std::invalid_argument);
  EXPECT_THROW(pair.system.set_asleep(0, true), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::simulation::engines
