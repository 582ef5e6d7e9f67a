#include <chrono>
#include <cmath>

#include "eval/touch/hold.h"
#include "prehend/simulation/world.h"

namespace prehend::eval::touch {

using namespace simulation;

namespace {

constexpr double kFriction = 0.7, kSafety = 1.2, kGraspHeight = 0.07, kLift = 0.05;

Scene scene_of(const std::string& engine, const HoldTest& test) {
  Scene scene;
  scene.step = test.step;
  scene.physics.engine = engine;
  scene.start_opening = 0.05;
  scene.carrier.start = {0, 0, kGraspHeight};
  contact::TexelLaw& law = scene.gripper.pad.law;
  law.viscous_friction = 0.1;
  law.bristle_law = contact::BristleLaw::kElastoPlastic;
  law.return_map = true;
  SceneObject box;
  box.name = "box";
  box.size = {0.07, 0.048, 0.1};
  box.mass = test.mass;
  box.friction = kFriction;
  scene.objects.push_back(box);
  return scene;
}

}  // namespace

HoldResult run_world_hold(const std::string& engine, const HoldTest& test) {
  const Scene scene = scene_of(engine, test);
  World world(scene);
  const auto height = [&] { return world.body("box").height; };
  const auto begin = std::chrono::steady_clock::now();
  // The current rises slowly: friction of the drive takes up to its stiction of the force.
  const SpindleDriveModel drive = drive_of(scene.gripper, scene.drive);
  const double press = kSafety * test.mass * scene.gravity / (2 * kFriction);
  const double current = (press + drive.static_friction) / drive.force_per_current();
  world.set_gripper_command(GripperMode::kVelocity, -0.005, std::min(current, 0.4));
  world.advance(0.6);
  for (int i = 1; i <= 100; ++i) {
    world.set_gripper_command(GripperMode::kCurrent, -current * i / 100);
    world.advance(0.01);
  }
  world.move_carrier(scene.carrier.gripper_pose({0, 0, kGraspHeight + kLift}, 0), 0.05);
  world.advance(3);
  const double at_start = height();
  world.advance(0.5 * test.duration);
  const double at_middle = height();
  double squares = 0;
  const auto steps = std::lround(0.5 * test.duration / test.step);
  for (long i = 0; i < steps; ++i) {
    world.step();
    squares += world.body(0).velocity.squaredNorm();
  }
  const std::chrono::duration<double> wall = std::chrono::steady_clock::now() - begin;
  HoldResult result;
  result.slip = at_middle - height();
  result.held = at_start > 0.9 * kLift && at_start - height() < 0.005;
  result.creep = result.slip / (0.5 * test.duration);
  result.jitter = std::sqrt(squares / static_cast<double>(steps));
  result.step_time = wall.count() / static_cast<double>(world.step_count());
  return result;
}

}  // namespace prehend::eval::touch
