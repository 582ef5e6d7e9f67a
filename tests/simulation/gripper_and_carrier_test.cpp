#include <cmath>
#include <limits>
#include <stdexcept>

#include <gtest/gtest.h>

#include "grasping.h"
#include "prehend/simulation/world.h"

namespace prehend::simulation {
namespace {

using testing::run;

Scene empty_scene(double step = 1e-3) {
  Scene scene;
  scene.step = step;
  scene.carrier.start = {0, 0, 0.3};
  return scene;
}

TEST(GripperDrive, MovesToAPositionWithinItsLimits) {
  for (const double step : {1e-4, 1e-3, 5e-3}) {
    World world(empty_scene(step));
    world.set_gripper_command(GripperMode::kPosition, 0.02);
    double fastest = 0, previous = 0, hardest = 0;
    for (int i = 0; i * step < 1.5; ++i) {
      world.step();
      const GripperReading gripper = world.gripper();
      fastest = std::max(fastest, std::abs(gripper.velocity));
      // Slower, friction gives way with a jerk: the Stribeck velocity is 2 mm/s.
      if (std::abs(previous) > 0.01 && std::abs(gripper.velocity) > 0.01) {
        hardest = std::max(hardest, std::abs(gripper.velocity - previous) / step);
      }
      previous = gripper.velocity;
    }
    EXPECT_NEAR(world.gripper().opening, 0.02, 10.0 / 1e6) << step << ", stiction over stiffness";
    EXPECT_NEAR(fastest, 0.083, 1e-3) << step;
    EXPECT_LT(hardest, 0.320 * 1.01) << step;
    EXPECT_GT(hardest, 0.320 * 0.9) << step;
    EXPECT_FALSE(world.gripper().moving);
    EXPECT_FALSE(world.gripper().blocked);
  }
}

TEST(GripperDrive, StopBrakesAndHolds) {
  World world(empty_scene());
  world.set_gripper_command(GripperMode::kVelocity, -0.05);
  run(world, 0.5);
  EXPECT_NEAR(world.gripper().velocity, -0.05, 1e-4);
  const double before = world.gripper().opening;
  world.set_gripper_command(GripperMode::kStop, 0);
  run(world, 0.5);
  EXPECT_NEAR(before - world.gripper().opening, 0.05 * 0.05 / (2 * 0.32), 2e-4);
  EXPECT_FALSE(world.gripper().moving);
}

TEST(GripperDrive, EndStopsHold) {
  World world(empty_scene());
  world.set_gripper_command(GripperMode::kCurrent, -2);
  run(world, 3);
  EXPECT_NEAR(world.gripper().opening, 0, 1.5e-4);
  world.set_gripper_command(GripperMode::kVelocity, 0.083);
  run(world, 3);
  EXPECT_NEAR(world.gripper().opening, 0.069, 1.5e-4);
}

TEST(GripperDrive, CurrentBelowFrictionDoesNotMove) {
  World world(empty_scene());
  world.set_gripper_command(GripperMode::kCurrent, -0.2);  // 6 N against 8 N
  run(world, 1);
  EXPECT_NEAR(world.gripper().opening, 0.069, 1e-4);
  EXPECT_TRUE(world.gripper().blocked);
}

TEST(GripperDrive, ForceFollowsTheCurrentAndIsCutAtTheMaximum) {
  for (const double current : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    Scene scene = testing::grasp_scene(1.0);
    scene.start_opening = 0.05;
    World world(scene);
    const double seconds = 2 * std::min(current, 10.0);
    testing::grasp_slowly(world, current, seconds);
    testing::expect_within(world.tactile_image(PadSide::kLeft).sum,
                           testing::force_of_slow_grasp(scene, current, seconds),
                           std::to_string(current).c_str());
    EXPECT_NEAR(world.gripper().current, -std::min(current, 6.5), 1e-6);
  }
}

// A current that comes at once: the rotor's inertia presses further than the current would, at most
// by the momentum's spring energy, and stiction keeps what it reached.
TEST(GripperDrive, AJerkOvershootsAndStictionKeepsIt) {
  for (const double current : {1.0, 2.0, 4.0}) {
    World world(testing::grasp_scene(1.0));
    testing::grasp(world, current);
    const double force = world.tactile_image(PadSide::kLeft).sum;
    EXPECT_GE(force, 30 * current - 10 - 0.01) << current;
    EXPECT_LE(force, 30 * current + 10) << current;
  }
}

// K (V - emf v) / R = friction: what the jaws' friction takes of the voltage is missing in their
// speed.
TEST(GripperDrive, VoltageGivesTheSpeedOfBackEmfLessFriction) {
  const SpindleDriveModel drive = drive_of(Scene().gripper, Scene().drive);
  const double K = drive.force_per_current(), emf = drive.torque_constant * drive.ratio();
  for (const double step : {1e-4, 1e-3, 5e-3}) {
    for (const double voltage : {1.0, 2.0, 3.0}) {
      World world(empty_scene(step));
      world.set_gripper_command(GripperMode::kVoltage, -voltage);
      run(world, 0.2);
      const double v = (K * voltage / drive.resistance - drive.coulomb_friction) /
                       (K * emf / drive.resistance + drive.viscous_friction);
      EXPECT_NEAR(world.gripper().velocity, -v, 0.005 * v) << voltage << ' ' << step;
      EXPECT_NEAR(world.gripper().current, -(voltage - emf * v) / drive.resistance, 0.003);
      EXPECT_TRUE(world.gripper().moving);
    }
  }
}

TEST(GripperDrive, VoltageKeepsSupplySpeedCurrentAndStroke) {
  for (const double step : {1e-4, 1e-3, 5e-3}) {
    for (const double voltage : {-1000.0, -24.0, 5.0, 24.0}) {
      Scene scene = empty_scene(step);
      scene.start_opening = voltage < 0 ? 0.069 : 0.0;
      World world(scene);
      world.set_gripper_command(GripperMode::kVoltage, voltage, 4.0);
      double fastest = 0;
      for (int i = 0; i * step < 2; ++i) {
        world.step();
        const GripperReading gripper = world.gripper();
        fastest = std::max(fastest, std::abs(gripper.velocity));
        ASSERT_LE(std::abs(gripper.current), 4.0 * 1.01) << voltage << ' ' << step;
        ASSERT_GT(gripper.opening, -2e-4) << voltage << ' ' << step;
        ASSERT_LT(gripper.opening, 0.0692) << voltage << ' ' << step;
      }
      EXPECT_LE(fastest, 0.083 * 1.01) << voltage << ' ' << step;
      EXPECT_GE(fastest, voltage == 5.0 ? 0.07 : 0.08) << voltage << ' ' << step;
      EXPECT_NEAR(world.gripper().opening, voltage < 0 ? 0 : 0.069, 5e-4) << voltage << ' ' << step;
      EXPECT_FALSE(world.gripper().moving);
    }
  }
}

// At a stand no back-EMF opposes it: F = K V / R.
TEST(GripperDrive, VoltagePressesWithItsStallForce) {
  Scene scene = testing::grasp_scene(1.0);
  scene.start_opening = 0.05;
  const SpindleDriveModel drive = drive_of(scene.gripper, scene.drive);
  for (const double voltage : {1.5, 3.0}) {
    World world(scene);
    world.set_gripper_command(GripperMode::kVelocity, -0.005, 0.3);
    run(world, 1.5);
    for (int i = 1; i <= 400; ++i) {  // slowly, lest the rotor's momentum presses too
      world.set_gripper_command(GripperMode::kVoltage, -voltage * i / 400);
      run(world, 0.01);
    }
    run(world, 1);
    const double stall = drive.force_per_current() * voltage / drive.resistance;
    EXPECT_LE(world.tactile_image(PadSide::kLeft).sum, stall - drive.coulomb_friction + 0.1);
    EXPECT_GE(world.tactile_image(PadSide::kLeft).sum, stall - drive.static_friction - 0.5);
    EXPECT_NEAR(world.gripper().current, -voltage / drive.resistance, 0.01 * voltage);
    EXPECT_TRUE(world.gripper().blocked);
  }
}

TEST(GripperDrive, NoVoltageBrakesByTheShortedWinding) {
  World world(empty_scene());
  world.set_gripper_command(GripperMode::kVelocity, -0.08);
  run(world, 0.4);
  const double before = world.gripper().opening;
  world.set_gripper_command(GripperMode::kVoltage, 0);
  run(world, 0.3);
  // tau = m R / (K emf) = 4.7 ms: 0.4 mm and less by friction.
  EXPECT_LT(before - world.gripper().opening, 0.08 * 0.0047);
  EXPECT_GT(before - world.gripper().opening, 0.5 * 0.08 * 0.0047);
  EXPECT_FALSE(world.gripper().moving);
  EXPECT_FALSE(world.gripper().blocked);
}

TEST(GripperDrive, RefusesBadCommands) {
  World world(empty_scene());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(world.set_gripper_command(GripperMode::kPosition, 0.07), std::invalid_argument);
  EXPECT_THROW(world.set_gripper_command(GripperMode::kPosition, -0.001), std::invalid_argument);
  EXPECT_THROW(world.set_gripper_command(GripperMode::kVelocity, nan), std::invalid_argument);
  EXPECT_THROW(world.set_gripper_command(GripperMode::kCurrent, 1, -2), std::invalid_argument);
  EXPECT_THROW(world.set_gripper_command(GripperMode::kVoltage, nan), std::invalid_argument);
  EXPECT_THROW(world.set_gripper_command(GripperMode::kVoltage, 1, -2), std::invalid_argument);
}

TEST(Carrier, FollowsAStraightTrapezoid) {
  for (const double step : {1e-4, 1e-3, 1e-2}) {
    World world(empty_scene(step));
    const CarrierModel& model = world.scene().carrier;
    const Eigen::Vector3d goal(0.3, -0.2, 0.5);
    world.move_carrier(model.gripper_pose(goal, 1.0), 0.25);
    const Eigen::Vector3d line = (goal - Eigen::Vector3d(0, 0, 0.3)).normalized();
    Eigen::Vector3d previous = Eigen::Vector3d::Zero();
    double time = 0;
    while (world.carrier().moving && time < 10) {
      world.step();
      time += step;
      const CarrierReading carrier = world.carrier();
      EXPECT_LE(carrier.velocity.norm(), 0.25 + 1e-9);
      EXPECT_LE((carrier.velocity - previous).norm() / step, 1.0 + 1e-6);
      const Eigen::Vector3d p = carrier.X_WG.translation() - Eigen::Vector3d(0, 0, 0.3);
      EXPECT_LT((p - p.dot(line) * line).norm(), 1e-9);
      previous = carrier.velocity;
    }
    const double length = (goal - Eigen::Vector3d(0, 0, 0.3)).norm();
    EXPECT_NEAR(time, length / 0.25 + 0.25 / 1.0, 0.01 + 4 * step);
    EXPECT_LT((world.carrier().X_WG.matrix() - model.gripper_pose(goal, 1.0).matrix()).norm(),
              1e-9);
  }
}

TEST(Carrier, StopBrakesAndANewGoalTakesOver) {
  World world(empty_scene());
  const CarrierModel& model = world.scene().carrier;
  world.move_carrier(model.gripper_pose({0.5, 0, 0.3}, 0), 0.4);
  run(world, 0.6);
  world.stop_carrier();
  run(world, 0.5);
  EXPECT_FALSE(world.carrier().moving);
  EXPECT_NEAR(world.carrier().X_WG.translation().x(), 0.5 * 0.4 * 0.4 + 0.2 * 0.4 + 0.08, 0.003);
  world.move_carrier(model.gripper_pose({0.5, 0, 0.3}, 0), 0.4);
  run(world, 0.5);
  world.move_carrier(model.gripper_pose({0, 0.1, 0.4}, 0.3), 0.4);
  run(world, 4);
  EXPECT_LT((world.carrier().X_WG.translation() - Eigen::Vector3d(0, 0.1, 0.4)).norm(), 1e-9);
}

TEST(Carrier, RefusesWhatItCannotReach) {
  World world(empty_scene());
  const CarrierModel& model = world.scene().carrier;
  EXPECT_THROW(world.move_carrier(model.gripper_pose({0, 0, 2}, 0), 0.1), std::invalid_argument);
  EXPECT_THROW(world.move_carrier(model.gripper_pose({0, 0, 0.3}, 0), 0), std::invalid_argument);
  geometry::RigidTransform tilted = model.gripper_pose({0, 0, 0.3}, 0);
  tilted.linear() = tilted.linear() * Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX());
  EXPECT_THROW(world.move_carrier(tilted, 0.1), std::invalid_argument);
}

TEST(Carrier, MountingTurnsTheApproachDirection) {
  CarrierModel model;
  EXPECT_TRUE(model.gripper_pose({0, 0, 0}, 0.7)
                  .linear()
                  .col(2)
                  .isApprox(-Eigen::Vector3d::UnitZ(), 1e-12));
  model.mounting_tilt = M_PI / 2;
  EXPECT_TRUE(
      model.gripper_pose({0, 0, 0}, 0).linear().col(2).isApprox(Eigen::Vector3d::UnitX(), 1e-12));
  EXPECT_TRUE(model.gripper_pose({0, 0, 0}, M_PI / 2)
                  .linear()
                  .col(2)
                  .isApprox(Eigen::Vector3d::UnitY(), 1e-12));
}

TEST(Wrist, FeelsFingersPressedOnTheTable) {
  World world(empty_scene());
  const CarrierModel& model = world.scene().carrier;
  const double tip = world.scene().gripper.tip_z();
  world.move_carrier(model.gripper_pose({0, 0, tip + 0.001}, 0), 0.2);
  run(world, 3);
  EXPECT_EQ(world.wrist_wrench().force.norm(), 0);
  world.move_carrier(model.gripper_pose({0, 0, tip - 0.0005}, 0), 0.2);
  run(world, 1);
  EXPECT_NEAR(world.wrist_wrench().force.z(), -8 * 2e4 * 0.0005, 1e-6) << "pushes back along -z_G";
}

}  // namespace
}  // namespace prehend::simulation
