// The pads, drive and sensors of a World together: what is felt, shown and held.

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <new>
#include <string>

#include <gtest/gtest.h>

#include "grasping.h"

namespace {
// Counts what this program allocates, for the test that steps do not.
thread_local long allocations = 0;
}  // namespace
[[gnu::noinline]] void* operator new(std::size_t size) {
  ++allocations;
  if (void* p = std::malloc(size ? size : 1)) return p;
  throw std::bad_alloc();
}
[[gnu::noinline]] void operator delete(void* p) noexcept { std::free(p); }
[[gnu::noinline]] void operator delete(void* p, std::size_t) noexcept { std::free(p); }

namespace prehend::simulation {
namespace {

using testing::above;
using testing::grasp;
using testing::grasp_scene;
using testing::grasp_slowly;
using testing::kGraspHeight;
using testing::run;

// Elasto-plastic bristles do not creep: 10 g to 10 kg, steps of 1 and 10 ms, either order, with a
// fifth more force than friction needs.
TEST(Pads, HoldTenGramsToTenKilogramsWithoutCreep) {
  for (const auto integration :
       {contact::Integration::kFirstOrder, contact::Integration::kSecondOrder}) {
    for (const double mass : {0.01, 0.1, 1.0, 10.0}) {
      for (const double step : {1e-3, 1e-2}) {
        Scene scene = grasp_scene(mass, 0.7, step);
        scene.physics.integration = integration;
        scene.gripper.pad.law.bristle_law = contact::BristleLaw::kElastoPlastic;
        scene.gripper.pad.law.return_map = true;
        scene.start_opening = 0.05;
        World world(scene);
        const double force = 1.2 * mass * 9.81 / (2 * 0.7);
        grasp_slowly(world, (force + 10) / 30, 1);
        world.move_carrier(above(world, kGraspHeight + 0.05), 0.05);
        run(world, 3);
        const double before = world.body("box").height;
        EXPECT_GT(before, 0.045) << mass << " " << step;
        run(world, 10);
        EXPECT_NEAR(world.body("box").height, before, 1e-6) << mass << " " << step;
      }
    }
  }
}

// The same on foam with creep and hysteresis; and a pad of other foam than its neighbour.
TEST(Pads, HoldOnFoamThatRemembers) {
  for (const auto integration :
       {contact::Integration::kFirstOrder, contact::Integration::kSecondOrder}) {
    for (const double mass : {0.01, 1.0, 10.0}) {
      for (const double step : {1e-3, 1e-2}) {
        Scene scene = grasp_scene(mass, 0.7, step);
        scene.physics.integration = integration;
        scene.gripper.pad.law.bristle_law = contact::BristleLaw::kElastoPlastic;
        scene.gripper.pad.law.return_map = true;
        scene.gripper.pad.law.memory = contact::FoamMemory::realistic();
        scene.start_opening = 0.05;
        World world(scene);
        grasp_slowly(world, (1.3 * mass * 9.81 / (2 * 0.7) + 10) / 30, 1);
        world.move_carrier(above(world, kGraspHeight + 0.05), 0.05);
        run(world, 3);
        const double before = world.body("box").height;
        EXPECT_GT(before, 0.045) << mass << " " << step;
        run(world, 5);
        EXPECT_NEAR(world.body("box").height, before, 1e-5) << mass << " " << step;
      }
    }
  }
}

// Jaws that stand where they are: pads relax, in fixed and adaptive steps alike, and each has the
// foam that it was calibrated with.
TEST(Pads, RelaxBetweenJawsThatStand) {
  std::vector<double> ends;
  for (const bool adaptive : {false, true}) {
    Scene scene = grasp_scene(0.3);
    scene.physics.integration = contact::Integration::kSecondOrder;
    scene.physics.adaptive = adaptive;
    robot::PadCalibration relaxing, elastic;
    relaxing.newton_per_count = elastic.newton_per_count = scene.gripper.pad.newton_per_count;
    relaxing.memory.creep = {{0.5, 1}};
    elastic.memory.creep = {{0.5, 1e6}};
    scene.tactile.calibrations = {relaxing, elastic};
    World world(scene);
    const double shut = 0.0474;
    world.set_gripper_command(GripperMode::kPosition, shut);
    world.advance(1);
    const double first = world.tactile_image(PadSide::kLeft).sum;
    EXPECT_GT(first, 5);
    world.advance(9);
    const double left = world.tactile_image(PadSide::kLeft).sum;
    EXPECT_NEAR(left, world.tactile_image(PadSide::kRight).sum, 0.1 * left);
    EXPECT_LT(left, 0.95 * first);
    // Both springs in series: the relaxed one of k and the other one of 1.5 k.
    const double depth = 0.048 - world.gripper().opening;
    EXPECT_NEAR(left, 84e3 * depth / (1 + 1 / 1.5), 0.05 * left);
    ends.push_back(left);
  }
  EXPECT_NEAR(ends[0], ends[1], 0.01 * ends[0]);
}

// What shaking five times by 0.1 m with 1 m/s^2 moves of a box held with a fifth more force than
// friction needs [m], downwards; the box's height if it was lost.
double lost_by_shaking(const robot::GripperModel& gripper, double mass) {
  Scene scene = grasp_scene(mass);
  scene.gripper = gripper;
  scene.start_opening = 0.05;
  World world(scene);
  const double force = 1.2 * mass * 9.81 / (2 * 0.7);
  grasp_slowly(world, (force + 10) / 30, 1);
  world.move_carrier(above(world, kGraspHeight + 0.05), 0.05);
  run(world, 3);
  const double lifted = world.body("box").height;
  if (lifted < 0.04) return 0.05;
  for (int i = 0; i < 5; ++i) {
    world.move_carrier(above(world, kGraspHeight + 0.15), 0.3);
    run(world, 1);
    world.move_carrier(above(world, kGraspHeight + 0.05), 0.3);
    run(world, 1);
  }
  return std::abs(world.body("box").height - lifted);
}

// The gripper's file chooses bristles that do not creep; the paper's LuGre law, the library's
// default, creeps while a load swings.
TEST(Pads, TheGrippersLawHoldsWhatLuGreLoses) {
  const robot::GripperModel pg70 = robot::read_gripper_model("config/robots/pg70_dsa.yaml");
  EXPECT_EQ(pg70.pad.law.bristle_law, contact::BristleLaw::kElastoPlastic);
  robot::GripperModel paper = pg70;
  paper.pad.law.bristle_law = contact::BristleLaw::kLuGre;
  paper.pad.law.return_map = false;
  for (const double mass : {0.01, 3.0}) {
    EXPECT_LT(lost_by_shaking(pg70, mass), 1e-6) << mass;
  }
  EXPECT_LT(lost_by_shaking(pg70, 10), 2e-5);
  EXPECT_GT(lost_by_shaking(paper, 1), 1e-3) << "if not, it may be the default again";
  EXPECT_GT(lost_by_shaking(paper, 10), 0.04);
}

// Two boxes between the jaws press on one another: one system for jaws and both.
TEST(Pads, TwoObjectsAreGrippedAtOnce) {
  Scene scene = grasp_scene(0.3);
  scene.objects[0].size = {0.06, 0.024, 0.1};
  scene.objects[0].y = -0.01201;
  scene.objects.push_back(scene.objects[0]);
  scene.objects[1].name = "other";
  scene.objects[1].y = 0.01201;
  scene.objects[1].mass = 0.1;
  World world(scene);
  grasp(world, 1.0);
  world.move_carrier(above(world, kGraspHeight + 0.05), 0.1);
  run(world, 1.2);
  EXPECT_NEAR(world.body("box").height, 0.05, 0.002);
  EXPECT_NEAR(world.body("other").height, 0.05, 0.002);
  // Left is at +y of the gripper, which is -y of the world when it looks down.
  EXPECT_TRUE(world.body("box").touches_left_pad && !world.body("box").touches_right_pad);
  EXPECT_TRUE(world.body("other").touches_right_pad && !world.body("other").touches_left_pad);
  EXPECT_NEAR(world.wrist_wrench().force.z(), 0.4 * 9.81, 1e-4);
  EXPECT_NEAR(world.tactile_image(PadSide::kLeft).sum, world.tactile_image(PadSide::kRight).sum,
              1e-4);
}

// A round can between flat pads: each texel is as deep as the circle's chord there.
TEST(Pads, ACanIsFeltAsACircle) {
  Scene scene = grasp_scene(0.3);
  scene.objects[0].shape = "can";
  scene.objects[0].radius = 0.03;
  scene.objects[0].height = 0.12;
  World world(scene);
  grasp(world, 1.0);
  run(world, 1);
  const TactileImage image = world.tactile_image(PadSide::kLeft);
  const double opening = world.gripper().opening;
  double sum = 0;
  for (int column = 0; column < image.columns; ++column) {
    const double x = (column - 2.5) * 0.0034;
    // Both pads alike; y of the surface on the pad's line less the pad's face.
    const double depth = std::sqrt(0.03 * 0.03 - x * x) - 0.5 * opening;
    const double expected = std::max(0.0, 1000 * depth);
    for (int row = 2; row < 12; ++row) {
      const int counts = image.counts[static_cast<std::size_t>(row * image.columns + column)];
      EXPECT_NEAR(counts * scene.gripper.pad.newton_per_count, expected, 0.02)
          << row << ", " << column;
    }
    sum += 14 * expected;
  }
  EXPECT_NEAR(image.sum, sum, 0.02 * sum);
}

TEST(Sensors, PadsShowTheirImperfections) {
  Scene scene = grasp_scene(0.3);
  scene.tactile.sensor.dead = {5, 40};
  scene.tactile.sensor.noise = 4;
  scene.tactile.sensor.gain_spread = 0.1;
  scene.tactile.sensor.threshold = 20;
  World world(scene), same(scene);
  scene.tactile.sensor.seed = 77;
  World other(scene);
  for (World* w : {&world, &same, &other}) grasp(*w, 1.0);
  const TactileImage image = world.tactile_image(PadSide::kLeft);
  EXPECT_EQ(image.counts, same.tactile_image(PadSide::kLeft).counts);
  EXPECT_NE(image.counts, other.tactile_image(PadSide::kLeft).counts);
  EXPECT_EQ(image.counts[5], 0);
  EXPECT_EQ(image.counts[40], 0);
  // Columns of the right pad run the other way: texel 5 of row 0 is shown in column 0.
  EXPECT_EQ(world.tactile_image(PadSide::kRight).counts[0], 0);
  EXPECT_GT(world.tactile_image(PadSide::kRight).counts[5], 20);
  const auto [least, most] =
      std::minmax_element(image.counts.begin() + 6, image.counts.begin() + 40);
  EXPECT_GT(*most - *least, 0.1 * *most) << "gains spread by 10 %";
  // Between frames it stays; then noise shows another.
  run(world, 0.005);
  const auto later = world.tactile_image(PadSide::kLeft).counts;
  run(world, 0.011);
  EXPECT_NE(world.tactile_image(PadSide::kLeft).counts, later);
}

TEST(Sensors, TheWristHasItsErrors) {
  Scene scene = grasp_scene(0.3);
  scene.wrench.emplace();
  scene.wrench->force_noise = 0.2;
  scene.wrench->bias[2] = 1.5;
  World world(scene);
  double mean = 0, squares = 0;
  constexpr int kSteps = 500;
  for (int i = 0; i < kSteps; ++i) {
    world.step();
    const Eigen::Vector3d force = world.wrist_wrench().force;
    mean += force.z() / kSteps;
    squares += force.x() * force.x() / kSteps;
    EXPECT_NEAR(std::remainder(force.x(), 0.01), 0, 1e-9) << "resolution";
  }
  EXPECT_NEAR(mean, 1.5, 0.05);
  EXPECT_NEAR(std::sqrt(squares), 0.2, 0.03);
}

TEST(Pads, AStepAllocatesNothing) {
  for (const std::string shape : {"box", "bottle"}) {
    for (const auto integration :
         {contact::Integration::kFirstOrder, contact::Integration::kSecondOrder}) {
      Scene scene = grasp_scene(0.3);
      scene.physics.integration = integration;
      scene.objects[0].shape = shape;
      scene.objects.push_back(scene.objects[0]);
      scene.objects[1].name = "aside";
      scene.objects[1].x = 0.2;
      World world(scene);
      grasp(world, 1.0);
      world.move_carrier(above(world, kGraspHeight + 0.1), 0.1);
      run(world, 0.2);
      const long before = allocations;
      run(world, 0.3);
      EXPECT_EQ(allocations - before, 0) << shape;
    }
  }
}

}  // namespace
}  // namespace prehend::simulation
