#pragma once

#include <algorithm>
#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "prehend/simulation/world.h"

/// A box of 48 mm width between the jaws, for tests.
namespace prehend::simulation::testing {

inline void run(World& world, double seconds) {
  const auto steps = static_cast<int>(seconds / world.scene().step + 0.5);
  for (int i = 0; i < steps; ++i) world.step();
}

/// A scene with one box between the open jaws, pads' centres at `kGraspHeight`.
constexpr double kGraspHeight = 0.07;
inline Scene grasp_scene(double mass, double friction = 0.7, double step = 1e-3) {
  Scene scene;
  scene.step = step;
  scene.gripper.pad.law.viscous_friction = 0.1;
  scene.carrier.start = {0, 0, kGraspHeight};
  SceneObject box;
  box.name = "box";
  box.size = {0.07, 0.048, 0.1};
  box.mass = mass;
  box.friction = friction;
  scene.objects.push_back(box);
  return scene;
}

inline geometry::RigidTransform above(const World& world, double height, double x = 0) {
  return world.scene().carrier.gripper_pose({x, 0, height}, 0);
}

/// Closes at 40 mm/s with 0.4 A (4 N), then presses with `current` [A] for half a second.
inline void grasp(World& world, double current) {
  world.set_gripper_command(GripperMode::kVelocity, -0.04, std::min(current, 0.4));
  run(world, 0.8);
  world.set_gripper_command(GripperMode::kCurrent, -current);
  run(world, 0.5);
}

/// Closes from `start_opening` at 5 mm/s with 0.4 A (4 N at most), then raises the current to
/// `current` [A] over `seconds`, so that the jaws creep in.
inline void grasp_slowly(World& world, double current, double seconds) {
  world.set_gripper_command(GripperMode::kVelocity, -0.005, std::min(current, 0.4));
  run(world, 0.6);
  const auto steps = static_cast<int>(seconds / world.scene().step + 0.5);
  for (int i = 1; i <= steps; ++i) {
    world.set_gripper_command(GripperMode::kCurrent, -current * i / steps);
    world.step();
  }
  run(world, 0.2);
}

/// What each pad feels after grasp_slowly of a box that covers the pads [N]: K i less the drive's
/// friction at the creeping speed v of the opening, K di/dt / (N k / 2), of two pads in series:
/// Fc + (Fs - Fc) exp(-(v/vs)^2) + sigma2 v; and at most so much more, which stiction keeps: what
/// the creeping mass presses further, v sqrt(m N k / 2), and the last step's rise of current.
struct ForceRange {
  double least, most;
};
inline ForceRange force_of_slow_grasp(const Scene& scene, double current, double seconds) {
  const SpindleDriveModel drive = drive_of(scene.gripper, scene.drive);
  const double K = drive.force_per_current();
  const double pads =
      scene.gripper.pad.rows * scene.gripper.pad.columns * scene.gripper.pad.law.stiffness / 2;
  const double speed = K * current / seconds / pads;
  const double sliding = speed / drive.stribeck_velocity;
  const double least =
      K * std::min(current, drive.peak_current) - drive.coulomb_friction -
      (drive.static_friction - drive.coulomb_friction) * std::exp(-sliding * sliding) -
      drive.viscous_friction * speed;
  return {least, least + speed * std::sqrt(drive.reflected_mass() * pads) +
                     scene.step * K * current / seconds};
}
inline void expect_within(double value, const ForceRange& range, const char* what) {
  EXPECT_GT(value, range.least - 1e-3) << what;
  EXPECT_LT(value, range.most + 1e-3) << what;
}

inline double height_of(const World& world) { return world.body("box").height; }

}  // namespace prehend::simulation::testing
