// The ports of a stage and its gripper, simulated.

#include "prehend/control/stage_in_world.h"

#include <cmath>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/shapes.h"

namespace prehend::control {
namespace {

class StageInWorldTest : public testing::Test {
 protected:
  static simulation::Scene scene_of(const robot::Platform& platform) {
    simulation::Scene scene;
    scene.gripper = *platform.hand.gripper;
    scene.carrier = simulation::carrier_of(platform, "side");
    return scene;
  }

  std::vector<double> here() { return stage.percepts(10).positions; }

  /// From `from` by (x, y, z, yaw) in `seconds`, at rest at both ends.
  static JointTrajectory way(std::vector<double> from, const std::vector<double>& by,
                             double seconds) {
    const std::vector<double> rest(4, 0.0);
    JointTrajectory path{{"arm_x", "arm_y", "arm_z", "arm_yaw"}, {{0, from, rest, rest}}};
    for (std::size_t i = 0; i < 4; ++i) from[i] += by[i];
    path.points.push_back({seconds, from, rest, rest});
    return path;
  }

  /// Until `motion` says something else than that it goes on, 10 s at most.
  template <class Port>
  MotionStatus end_of(Port& port) {
    const double limit = world.time() + 10;
    while (port.motion() == MotionStatus::kMoving && world.time() < limit) stage.advance(1);
    return port.motion();
  }

  const robot::Platform platform = robot::read_platform("config/robots/stage_pg70.yaml");
  simulation::World world{scene_of(platform)};
  StageInWorld stage{world, platform, "side"};
  WorldGripper gripper{world};
};

TEST_F(StageInWorldTest, SaysWhatItFeels) {
  const ArmPercepts percepts = stage.percepts(10);
  EXPECT_EQ(percepts.names, (std::vector<std::string>{"arm_x", "arm_y", "arm_z", "arm_yaw"}));
  const robot::Positions side = platform.home("side").arm;
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(percepts.positions[static_cast<std::size_t>(i)], side[i], 1e-12);
  }
  ASSERT_EQ(percepts.pads.size(), 2u);
  EXPECT_EQ(percepts.pads[0].name, "left");
  EXPECT_EQ(percepts.pads[1].name, "right");
  ASSERT_TRUE(percepts.gripper);
  EXPECT_NEAR(percepts.gripper->opening, 0.069, 1e-6);
}

TEST_F(StageInWorldTest, GripperMovesOrSaysThatItDoesNot) {
  gripper.move_to(0.03, 0.05);
  EXPECT_EQ(gripper.motion(), MotionStatus::kMoving);
  EXPECT_EQ(end_of(gripper), MotionStatus::kReached);
  EXPECT_NEAR(world.gripper().opening, 0.03, 3e-4);
  gripper.move_to(0.2, 0.05);
  EXPECT_EQ(gripper.motion(), MotionStatus::kFailed) << "wider than it opens";
  gripper.move_to(0.03, 0);
  EXPECT_EQ(gripper.motion(), MotionStatus::kFailed) << "no speed";
  gripper.move_to(0.05, 0.05);
  EXPECT_EQ(end_of(gripper), MotionStatus::kReached) << "a refusal does not last";
}

TEST_F(StageInWorldTest, ArmFollowsAndBrakesBeforeItFollowsAnew) {
  const std::vector<double> start = here();
  stage.arm().follow(way(start, {0.2, 0, 0, 0}, 2), 0);
  EXPECT_EQ(end_of(stage.arm()), MotionStatus::kReached);
  EXPECT_NEAR(here()[0], start[0] + 0.2, 1e-4);
  const std::vector<double> there = here();
  stage.arm().follow(way(there, {-0.2, 0, 0, 0}, 2), 0);
  for (int i = 0; i < 1000; ++i) {
    EXPECT_EQ(stage.arm().motion(), MotionStatus::kMoving);  // it begins when the arm stands
    stage.advance(1);
  }
  EXPECT_TRUE(world.carrier().moving);
  // It does not begin where the arm is now, and is refused when the arm stands.
  stage.arm().follow(way(there, {0, 0.1, 0, 0}, 2), 0);
  EXPECT_EQ(stage.arm().motion(), MotionStatus::kMoving) << "it brakes";
  EXPECT_EQ(end_of(stage.arm()), MotionStatus::kFailed);
  EXPECT_NE(stage.arm().problem().find("starts"), std::string::npos) << stage.arm().problem();
  EXPECT_FALSE(world.carrier().moving);
  EXPECT_NEAR(here()[1], start[1], 1e-9);
  stage.arm().follow(way(here(), {0, 0.1, 0, 0}, 2), 0);
  EXPECT_EQ(end_of(stage.arm()), MotionStatus::kReached);
}

TEST_F(StageInWorldTest, ArmStopsAtContact) {
  world.add_object("block", simulation::make_standing_box({0.2, 0.2, 0.2}), 5);
  world.place_object("block",
                     geometry::make_transform(Eigen::Quaterniond::Identity(), {here()[0], 0, 0.1}));
  stage.arm().follow(way(here(), {0, 0, -0.25, 0}, 4), 5);
  EXPECT_EQ(end_of(stage.arm()), MotionStatus::kContact);
  EXPECT_GT(here()[2], 0.2) << "it was to go to 0.2, into the block";
  stage.arm().follow(way(here(), {0, 0, 0.1, 0}, 2), 0);
  EXPECT_EQ(end_of(stage.arm()), MotionStatus::kReached) << "free again";
}

TEST(StageInWorldRefuses, WhatIsNoStage) {
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  simulation::World world{simulation::Scene()};
  EXPECT_THROW(StageInWorld(world, platform, "side"), geometry::InputError);
}

}  // namespace
}  // namespace prehend::control
