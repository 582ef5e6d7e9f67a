#include <cmath>
#include <string>

#include <gtest/gtest.h>

#include "grasping.h"

namespace prehend::simulation {
namespace {

using testing::above;
using testing::grasp;
using testing::grasp_scene;
using testing::height_of;
using testing::kGraspHeight;
using testing::run;

// Current that presses with twice the force friction 0.7 needs, from both pads.
double adequate_current(const World& world, double mass) {
  const robot::GripperModel& gripper = world.scene().gripper;
  const double needed = mass * world.scene().gravity / (2 * 0.7);
  return std::min((2 * needed + 5 + gripper.friction_force) / gripper.force_per_current,
                  gripper.max_current);
}

class Hold : public ::testing::TestWithParam<double> {};

TEST_P(Hold, LiftsHoldsAndPutsDown) {
  const double mass = GetParam();
  World world(grasp_scene(mass));
  grasp(world, adequate_current(world, mass));
  world.move_carrier(above(world, kGraspHeight + 0.1), 0.1);
  run(world, 2);
  const double lifted = height_of(world);
  EXPECT_NEAR(lifted, 0.1, 0.004);
  run(world, 5);
  EXPECT_NEAR(height_of(world), lifted, 5e-4) << "slips while held";
  EXPECT_NEAR(world.wrist_wrench().force.z(), mass * 9.81, 1e-3 * mass * 9.81)
      << "gripper's z points down: the weight pulls along +z";
  world.move_carrier(above(world, kGraspHeight + 0.001), 0.1);
  run(world, 2);
  world.set_gripper_command(GripperMode::kPosition, 0.069);
  run(world, 1.5);
  world.move_carrier(above(world, 0.3), 0.2);
  run(world, 2);
  const BodyReading box = world.body("box");
  EXPECT_NEAR(box.height, 0, 2e-4);
  EXPECT_TRUE(box.touches_table);
  EXPECT_FALSE(box.touches_left_pad || box.touches_right_pad);
  EXPECT_LT(std::hypot(box.X_WB.translation().x(), box.X_WB.translation().y()), 0.002);
  EXPECT_GT(box.X_WB.linear()(2, 2), 0.9999) << "stands upright";
  RecordProperty("lifted_mm", std::to_string(1e3 * lifted));
}
INSTANTIATE_TEST_SUITE_P(FiftyGramsToThreeKilograms, Hold, ::testing::Values(0.05, 0.3, 1.0, 3.0));

TEST(Grasp, HoldsOneHundredTimesTheJawsMassRatio) {
  Scene scene = grasp_scene(3.0);
  scene.gripper.jaw_mass = 0.03;
  scene.drive.rotor_inertia = 1e-12;  // its 3.9 kg on the jaws would be no light jaw
  World world(scene);
  grasp(world, 2.2);
  world.move_carrier(above(world, kGraspHeight + 0.05), 0.05);
  run(world, 3);
  EXPECT_GT(height_of(world), 0.045);
}

TEST(Grasp, TooWeakDrops) {
  World world(grasp_scene(3.0));
  grasp(world, 0.6);  // 10 N on each pad: 14 N of friction for 29 N of weight
  world.move_carrier(above(world, kGraspHeight + 0.1), 0.1);
  run(world, 3);
  EXPECT_LT(height_of(world), 0.005);
}

TEST(Grasp, TooSlipperyDrops) {
  World world(grasp_scene(1.0, 0.05));
  grasp(world, 1.0);
  world.move_carrier(above(world, kGraspHeight + 0.1), 0.1);
  run(world, 3);
  EXPECT_LT(height_of(world), 0.005);
}

TEST(Grasp, OppositePadsFeelEqualForcesOfTheDrive) {
  Scene scene = grasp_scene(0.3);
  scene.start_opening = 0.05;
  World world(scene);
  testing::grasp_slowly(world, 1.0, 2);
  const TactileImage left = world.tactile_image(PadSide::kLeft);
  const TactileImage right = world.tactile_image(PadSide::kRight);
  testing::expect_within(left.sum, testing::force_of_slow_grasp(scene, 1.0, 2), "left");
  EXPECT_NEAR(left.sum, right.sum, 1e-6);
  int touched = 0;
  for (std::size_t i = 0; i < left.counts.size(); ++i) {
    EXPECT_NEAR(left.counts[i], right.counts[i], 1) << i;
    touched += left.counts[i] > 0;
  }
  EXPECT_EQ(touched, 84) << "the box is larger than the pads";
  EXPECT_NEAR(left.counts[40] * world.scene().gripper.pad.newton_per_count, left.sum / 84, 0.01);
  const GripperReading gripper = world.gripper();
  EXPECT_TRUE(gripper.blocked);
  EXPECT_NEAR(gripper.opening, 0.048 - 2 * left.sum / 84 / 1000, 1e-9) << "F = N k d at each pad";
}

TEST(Grasp, EdgeContactTouchesOnlyTheCoveredRows) {
  Scene scene = grasp_scene(0.3);
  // Box top at 100 mm; pad's centre at 100 mm: the lower half (towards the tip) touches.
  scene.carrier.start.z() = 0.1;
  World world(scene);
  grasp(world, 0.5);
  const TactileImage image = world.tactile_image(PadSide::kLeft);
  for (int row = 0; row < image.rows; ++row) {
    for (int column = 0; column < image.columns; ++column) {
      const int counts = image.counts[row * image.columns + column];
      EXPECT_EQ(counts > 0, row < 7) << row << ", " << column << ": " << counts;
    }
  }
}

// Holding height and pad force may depend on the step only as far as this says.
TEST(Grasp, StepSizesAgree) {
  for (const double step : {1e-4, 5e-4, 2e-3, 5e-3, 1e-2}) {
    Scene scene = grasp_scene(1.0, 0.7, step);
    scene.start_opening = 0.05;
    World world(scene);
    testing::grasp_slowly(world, 1.0, 2);
    const double pressed = world.tactile_image(PadSide::kLeft).sum;
    testing::expect_within(pressed, testing::force_of_slow_grasp(scene, 1.0, 2),
                           std::to_string(step).c_str());
    world.move_carrier(above(world, kGraspHeight + 0.1), 0.1);
    run(world, 3);
    EXPECT_NEAR(world.tactile_image(PadSide::kLeft).sum, pressed, 1e-4) << step;
    EXPECT_NEAR(height_of(world), 0.1, 0.002) << step;
    RecordProperty("height_mm_at_step_" + std::to_string(step),
                   std::to_string(1e3 * height_of(world)));
  }
}

// After settling the box hangs still: mg is borne to rounding, and it slips by less than 1 um/s.
TEST(Grasp, HeldObjectsNeitherSlipNorSwing) {
  for (const double mass : {0.05, 0.35, 1.0}) {
    World world(grasp_scene(mass));
    grasp(world, adequate_current(world, mass));
    world.move_carrier(above(world, kGraspHeight + 0.05), 0.1);
    run(world, 3);
    const double before = height_of(world);
    run(world, 5);
    EXPECT_NEAR(height_of(world), before, 5 * 1e-6) << mass;
    const ContactWrench wrench = world.wrist_wrench();
    EXPECT_NEAR(wrench.force.z(), mass * 9.81, 1e-6 * mass * 9.81) << mass;
    EXPECT_LT(wrench.force.head<2>().norm(), 1e-6) << mass;
    RecordProperty("slip_um_per_s", std::to_string(1e6 * (before - height_of(world)) / 5));
  }
}

TEST(Grasp, AnOffCentreBoxIsCentred) {
  Scene scene = grasp_scene(0.3);
  scene.objects[0].y = 0.004;
  World world(scene);
  grasp(world, 1.0);
  EXPECT_NEAR(world.body("box").X_WB.translation().y(), 0, 0.0015);
  EXPECT_NEAR(world.tactile_image(PadSide::kLeft).sum, world.tactile_image(PadSide::kRight).sum,
              2 * 0.5 * 0.3 * 9.81 + 0.1)
      << "differ by the table's friction at most";
}

TEST(Grasp, SpawnedMeshIsGraspedLikeASceneObject) {
  Scene scene = grasp_scene(0.3);
  scene.objects.clear();
  World world(scene);
  geometry::TriangleMesh mesh = geometry::make_box({0.06, 0.04, 0.09});
  for (auto& v : mesh.vertices) v += Eigen::Vector3d(0, 0, 0.043);  // 2 mm into the table
  world.add_object("box", mesh, 0.2);
  grasp(world, 1.0);
  world.move_carrier(above(world, kGraspHeight + 0.1), 0.2);
  run(world, 2);
  EXPECT_NEAR(height_of(world), 0.1, 0.003);
}

}  // namespace
}  // namespace prehend::simulation
