// Random scenes handled roughly, with steps from 1 to 20 ms: nothing becomes infinite, nothing is
// shot away, the same seed gives the same end.

#include <cmath>
#include <random>
#include <string>

#include <gtest/gtest.h>

#include "grasping.h"

namespace prehend::simulation {
namespace {

using testing::run;

Scene random_scene(std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  const auto log_between = [&](double least, double most) {
    return least * std::pow(most / least, unit(random));
  };
  Scene scene;
  scene.step = log_between(1e-3, 2e-2);
  scene.physics.integration =
      unit(random) < 0.5 ? contact::Integration::kFirstOrder : contact::Integration::kSecondOrder;
  scene.physics.rules.rigid_pads = unit(random) < 0.2;
  scene.physics.rules.primitives = unit(random) < 0.5;
  scene.carrier.start = {0, 0, 0.3};
  scene.start_opening = 0.069 * unit(random);
  contact::TexelLaw& law = scene.gripper.pad.law;
  law.stiffness = log_between(10, 1e7);
  law.damping = unit(random) < 0.2 ? 0 : log_between(1e-3, 1e3);
  law.bristle_stiffness = log_between(10, 1e7);
  law.bristle_damping = 0;
  law.dynamic_friction = law.static_friction = unit(random) < 0.2 ? 0 : 0.8;
  if (unit(random) < 0.5) law.bristle_law = contact::BristleLaw::kElastoPlastic;
  law.return_map = unit(random) < 0.5;
  const char* shapes[] = {"box", "can", "ball", "bottle", "mug"};
  const int count = 1 + static_cast<int>(3 * unit(random));
  for (int i = 0; i < count; ++i) {
    SceneObject object;
    object.shape = shapes[static_cast<int>(5 * unit(random)) % 5];
    object.name = "object" + std::to_string(i);
    object.mass = log_between(1e-3, 30);
    object.friction = unit(random);
    object.size = {0.02 + 0.06 * unit(random), 0.02 + 0.06 * unit(random),
                   0.02 + 0.1 * unit(random)};
    object.radius = 0.015 + 0.03 * unit(random);
    object.x = 0.12 * i;
    object.y = 0.02 * (unit(random) - 0.5);
    scene.objects.push_back(object);
  }
  return scene;
}

void handle(World& world, std::mt19937& random) {
  std::uniform_real_distribution<double> unit(0, 1);
  for (int i = 0; i < 5; ++i) {
    const double choice = unit(random);
    if (choice < 0.3) {
      world.set_gripper_command(GripperMode::kCurrent, 13 * (unit(random) - 0.5));
    } else if (choice < 0.5) {
      world.set_gripper_command(GripperMode::kPosition, 0.069 * unit(random));
    } else if (choice < 0.85) {
      world.move_carrier(
          world.scene().carrier.gripper_pose(
              {0.3 * (unit(random) - 0.5), 0.3 * (unit(random) - 0.5), 0.03 + 0.2 * unit(random)},
              3 * (unit(random) - 0.5)),
          0.5);
    } else {
      // From the height of a table: it arrives at 4 m/s.
      world.place_object(
          "object0", geometry::make_transform(Eigen::Quaterniond(1, unit(random), unit(random), 0),
                                              {0, 0, 0.9}));
    }
    run(world, 0.3);
  }
}

TEST(RoughHandling, NothingIsShotAway) {
  double fastest = 0;
  for (unsigned seed = 1; seed <= 30; ++seed) {
    std::mt19937 random(seed);
    const Scene scene = random_scene(random);
    World world(scene);
    handle(world, random);
    for (std::size_t i = 0; i < world.body_count(); ++i) {
      const BodyReading body = world.body(i);
      ASSERT_TRUE(body.X_WB.matrix().allFinite() && body.velocity.allFinite()) << "seed " << seed;
      fastest = std::max(fastest, body.velocity.norm());
      EXPECT_LT(body.velocity.norm(), 8) << "seed " << seed << ", " << body.name;
      EXPECT_LT(body.X_WB.translation().norm(), 8) << "seed " << seed << ", " << body.name;
      EXPECT_GT(body.height, -0.02) << "seed " << seed << ", " << body.name;
    }
    ASSERT_TRUE(world.wrist_wrench().force.allFinite()) << seed;
    EXPECT_GE(world.gripper().opening, -1e-3) << seed;
  }
  RecordProperty("fastest", std::to_string(fastest));
}

// What begins inside the fingers or another object is pushed out with what was put in, no more than
// that: it stays finite, and comes to rest.
TEST(RoughHandling, DeepInitialPenetrationComesToRest) {
  for (const double step : {1e-3, 1e-2}) {
    Scene scene = testing::grasp_scene(0.5, 0.7, step);
    scene.start_opening = 0.02;  // the box is 48 mm wide
    scene.objects.push_back(scene.objects[0]);
    scene.objects[1].name = "inside";
    scene.objects[1].x = 0.068;  // 2 mm in the first
    World world(scene);
    run(world, 2);
    for (const char* name : {"box", "inside"}) {
      const BodyReading body = world.body(name);
      ASSERT_TRUE(body.X_WB.matrix().allFinite()) << name;
      EXPECT_LT(body.velocity.norm(), 1e-3) << name << " " << step;
      EXPECT_LT(body.X_WB.translation().norm(), 1) << name << " " << step;
    }
  }
}

TEST(RoughHandling, TheSameSeedGivesTheSameEnd) {
  for (unsigned seed = 100; seed < 102; ++seed) {
    const auto end = [seed] {
      std::mt19937 random(seed);
      World world(random_scene(random));
      handle(world, random);
      return world.save_bytes();
    };
    EXPECT_TRUE(end() == end()) << seed;
  }
}

}  // namespace
}  // namespace prehend::simulation
