// Steps as long as a tolerance allows: against fine fixed steps, repeated, round events.

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "grasping.h"

namespace prehend::simulation {
namespace {

using testing::above;
using testing::grasp_scene;
using testing::kGraspHeight;

Scene adaptive_scene(double mass, double tolerance = 1e-5) {
  Scene scene = grasp_scene(mass);
  scene.start_opening = 0.06;
  scene.physics.adaptive = true;
  scene.physics.tolerance = tolerance;
  return scene;
}

Scene fine_scene(double mass, double step = 1e-4) {
  Scene scene = adaptive_scene(mass);
  scene.physics.adaptive = false;
  scene.physics.integration = contact::Integration::kSecondOrder;
  scene.step = step;
  return scene;
}

struct Moment {
  Eigen::Vector3d box;
  double opening = 0, force = 0;
};

// Closes, presses, lifts, holds, puts down, opens, goes; what is there at each phase's end.
std::vector<Moment> cycle(World& world) {
  std::vector<Moment> moments;
  const auto advance = [&](double seconds) {
    world.advance(seconds);
    moments.push_back({world.body("box").X_WB.translation(), world.gripper().opening,
                       world.tactile_image(PadSide::kLeft).sum});
  };
  world.set_gripper_command(GripperMode::kVelocity, -0.01, 0.4);
  advance(1.5);
  world.set_gripper_command(GripperMode::kCurrent, -1.0);
  advance(0.5);
  world.move_carrier(above(world, kGraspHeight + 0.1), 0.05);
  advance(1.2);
  advance(1.8);
  advance(5);
  world.move_carrier(above(world, kGraspHeight + 0.0005), 0.05);
  advance(3);
  world.set_gripper_command(GripperMode::kPosition, 0.069);
  advance(2);
  world.move_carrier(above(world, 0.3), 0.1);
  advance(3);
  return moments;
}

// The box at every phase's end, within the tolerance of steps of 0.1 ms and second order; the jaws,
// which both pads let creep, within twice that. The reference's own carrier lags by a h t / 2 until
// it stands, so there is nothing to be compared while it moves.
TEST(Adaptive, AgreesWithFineSteps) {
  for (const double mass : {0.1, 1.0}) {
    World fine(fine_scene(mass));
    const std::vector<Moment> reference = cycle(fine);
    EXPECT_GT(reference[3].box.z(), 0.09) << "it is lifted";
    for (const double tolerance : {1e-4, 1e-5}) {
      World world(adaptive_scene(mass, tolerance));
      const std::vector<Moment> moments = cycle(world);
      EXPECT_NEAR(world.time(), fine.time(), 1e-9);
      for (std::size_t i = 0; i < moments.size(); ++i) {
        SCOPED_TRACE(std::to_string(mass) + " kg, phase " + std::to_string(i));
        if (i != 2) {
          EXPECT_LT((moments[i].box - reference[i].box).norm(), tolerance);
        }
        EXPECT_NEAR(moments[i].opening, reference[i].opening, 2 * tolerance);
      }
    }
  }
}

// Jaws that stand against a box with little current get more, and press on: they speed up from a
// stand, however long the steps were in which they were blocked. (Jaws a ramp ahead are 0.12 mm.)
TEST(Adaptive, PressesOnAsFineStepsDo) {
  const auto press = [](const Scene& scene) {
    World world(scene);
    world.set_gripper_command(GripperMode::kVelocity, -0.01, 0.4);
    world.advance(1.5);
    world.set_gripper_command(GripperMode::kCurrent, -1.0);
    std::vector<double> openings;
    for (int i = 0; i < 10; ++i) {
      world.advance(0.01);
      openings.push_back(world.gripper().opening);
    }
    return openings;
  };
  const std::vector<double> fine = press(fine_scene(0.3));
  EXPECT_GT(fine.front() - fine.back(), 2e-4) << "it presses on";
  for (const double tolerance : {1e-5, 1e-6}) {
    const std::vector<double> adaptive = press(adaptive_scene(0.3, tolerance));
    for (std::size_t i = 0; i < fine.size(); ++i) {
      EXPECT_NEAR(adaptive[i], fine[i], 4e-5) << tolerance << " m, slice " << i;
    }
  }
}

// A motor at a voltage speeds up within milliseconds, brakes at its stop, and is reversed there.
TEST(Adaptive, FollowsAVoltage) {
  const auto run = [](const Scene& scene) {
    World world(scene);
    std::vector<double> openings;
    for (const double voltage : {-1.5, -3.0, 0.0, -24.0, 2.0}) {
      world.set_gripper_command(GripperMode::kVoltage, voltage);
      world.advance(0.6);
      openings.push_back(world.gripper().opening);
    }
    return openings;
  };
  const std::vector<double> fine = run(fine_scene(0.1)), adaptive = run(adaptive_scene(0.1, 1e-5));
  for (std::size_t i = 0; i < fine.size(); ++i) EXPECT_NEAR(adaptive[i], fine[i], 1e-4) << i;
}

TEST(Adaptive, MeetsTheTableWithinTheTolerance) {
  const auto fall = [](Scene scene) {
    scene.physics.rules.sleep = false;
    World world(scene);
    world.move_carrier(above(world, 0.5, 0.3), 0.5);
    world.place_object("box",
                       geometry::make_transform(Eigen::Quaterniond::Identity(), {-0.3, 0, 0.05}));
    std::vector<double> heights;
    for (int i = 0; i < 20; ++i) {
      world.advance(0.05);
      heights.push_back(world.body("box").X_WB.translation().z());
    }
    return heights;
  };
  const auto reference = fall(fine_scene(0.3, 2e-5)), heights = fall(adaptive_scene(0.3));
  EXPECT_NEAR(reference[0], 0.05 - 0.5 * 9.81 * 0.0025, 1e-5) << "falls";
  EXPECT_LT(reference[19], 1e-4) << "has landed";
  for (int i = 0; i < 20; ++i) EXPECT_NEAR(heights[i], reference[i], 1e-5) << i;
}

// Speed and place on a straight line at any time are those of the trapezoid.
TEST(Adaptive, TheCarriersRampsAreExact) {
  Scene scene = adaptive_scene(0.3);
  scene.objects.clear();
  scene.carrier.start = {0, 0, 0.2};
  World world(scene);
  world.move_carrier(above(world, 0.3), 0.2);  // 1 m/s^2: 0.2 s up, 0.3 s at 0.2 m/s, 0.2 s down
  for (int i = 1; i <= 80; ++i) {
    world.advance(0.01);
    const double t = world.time();
    const double way = t < 0.2   ? 0.5 * t * t
                       : t < 0.5 ? 0.02 + 0.2 * (t - 0.2)
                       : t < 0.7 ? 0.1 - 0.5 * (0.7 - t) * (0.7 - t)
                                 : 0.1;
    const double speed = t < 0.2 ? t : t < 0.5 ? 0.2 : t < 0.7 ? 0.7 - t : 0.0;
    EXPECT_NEAR(world.carrier().X_WG.translation().z(), 0.2 + way, 1e-12) << t;
    EXPECT_NEAR(world.carrier().velocity.z(), speed, 1e-9) << t;
  }
  EXPECT_FALSE(world.carrier().moving);
  world.move_carrier(above(world, 0.1), 0.3);
  world.advance(0.1);
  world.stop_carrier();
  world.advance(1);
  EXPECT_NEAR(world.carrier().X_WG.translation().z(), 0.3 - 0.01, 1e-9) << "braked: v^2 / a";
  EXPECT_FALSE(world.carrier().moving);
  // Another target while it moves: brakes first, then goes there.
  world.move_carrier(above(world, 0.1), 0.3);
  world.advance(0.2);
  world.move_carrier(above(world, 0.25), 0.3);
  world.advance(2);
  EXPECT_NEAR(world.carrier().X_WG.translation().z(), 0.25, 1e-12);
}

TEST(Adaptive, SameCallsGiveBitwiseTheSameAndStatesContinue) {
  World a(adaptive_scene(0.3)), b(adaptive_scene(0.3));
  cycle(a);
  cycle(b);
  EXPECT_EQ(a.save_bytes(), b.save_bytes());
  World c(adaptive_scene(0.3));
  c.set_gripper_command(GripperMode::kVelocity, -0.02, 0.4);
  c.advance(0.6);
  const std::string kept = c.save_bytes();
  c.advance(1);
  const std::string end = c.save_bytes();
  World d(adaptive_scene(0.3));
  d.restore_bytes(kept);
  d.advance(1);
  EXPECT_EQ(d.save_bytes(), end);
}

TEST(Adaptive, FramesComeAtTheirPeriod) {
  Scene scene = adaptive_scene(0.3);
  scene.tactile.sensor.noise = 5;
  scene.tactile.period = 0.01;
  World world(scene);
  world.advance(0.5);
  int changes = 0;
  TactileImage last = world.tactile_image(PadSide::kLeft);
  for (int i = 0; i < 200; ++i) {
    world.advance(0.002);
    const TactileImage image = world.tactile_image(PadSide::kLeft);
    changes += image.counts != last.counts;
    last = image;
  }
  EXPECT_EQ(changes, 40);
}

TEST(Adaptive, FixedStepsAdvanceAsStepsDo) {
  Scene scene = adaptive_scene(0.3);
  scene.physics.adaptive = false;
  World a(scene), b(scene);
  for (World* world : {&a, &b}) world->set_gripper_command(GripperMode::kVelocity, -0.02, 0.4);
  a.advance(0.7);
  testing::run(b, 0.7);
  EXPECT_EQ(a.save_bytes(), b.save_bytes());
  for (const double wrong : {-0.001, 0.0005, std::nan(""), HUGE_VAL}) {
    EXPECT_THROW(a.advance(wrong), std::invalid_argument) << wrong;
  }
  scene.physics.adaptive = true;
  scene.physics.tolerance = 0;
  EXPECT_THROW(World{scene}, std::invalid_argument);
}

}  // namespace
}  // namespace prehend::simulation
