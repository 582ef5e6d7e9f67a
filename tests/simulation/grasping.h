#pragma once

#include <algorithm>

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

inline double height_of(const World& world) { return world.body("box").height; }

}  // namespace prehend::simulation::testing
