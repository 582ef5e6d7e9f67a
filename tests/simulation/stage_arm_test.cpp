#include "prehend/simulation/stage_arm.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <gtest/gtest.h>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/world_commands.h"

namespace prehend::simulation {
namespace {

const robot::Platform& stage_pg70() {
  static const robot::Platform platform = robot::read_platform("config/robots/stage_pg70.yaml");
  return platform;
}

/// An empty table under the stage.
struct Stage {
  World world;
  StageArm arm{stage_pg70(), "home"};

  static Scene scene(bool adaptive) {
    Scene scene;
    scene.carrier = carrier_of(stage_pg70(), "home");
    scene.physics.adaptive = adaptive;
    return scene;
  }
  explicit Stage(bool adaptive = false) : world(scene(adaptive)) {}
  void step() { arm.advance(world, 1); }
  void run(double seconds) {
    for (std::int64_t left = std::lround(seconds / world.scene().step); left > 0;) {
      left -= arm.advance(world, std::min<std::int64_t>(left, 10));
    }
  }
  /// Smoothly from where it is, by so much.
  TrajectoryRequest by(const Eigen::Vector4d& way, double seconds) const {
    TrajectoryRequest request;
    request.joints = {"arm_x", "arm_y", "arm_z", "arm_yaw"};
    const robot::Positions q = stage_position(world);
    const std::vector<double> none(4, 0.0);
    std::vector<double> from, to;
    for (int i = 0; i < 4; ++i) {
      from.push_back(q[i]);
      to.push_back(q[i] + way[i]);
    }
    request.points = {{0, from, none, none}, {seconds, to, none, none}};
    return request;
  }
};

TEST(StageArm, IsThePlatformsCarrier) {
  const CarrierModel carrier = carrier_of(stage_pg70(), "home");
  const CarrierModel defaults;
  EXPECT_EQ(carrier.minimum, defaults.minimum);
  EXPECT_EQ(carrier.maximum, defaults.maximum);
  EXPECT_EQ(carrier.max_speed, defaults.max_speed);
  EXPECT_EQ(carrier.max_acceleration, defaults.max_acceleration);
  EXPECT_EQ(carrier.max_yaw_rate, defaults.max_yaw_rate);
  EXPECT_EQ(carrier.start, defaults.start);
}

TEST(StageArm, RefusesWhatIsNoStageOfTheWorld) {
  robot::Platform arm = robot::read_platform("config/robots/kr5_pg70.yaml");
  EXPECT_THROW(carrier_of(arm, "home"), geometry::InputError);
  robot::Platform askew = stage_pg70();
  askew.X_WB.rotate(Eigen::AngleAxisd(0.1, Eigen::Vector3d::UnitZ()));
  EXPECT_THROW(carrier_of(askew, "home"), geometry::InputError);
  EXPECT_THROW(carrier_of(stage_pg70(), "hme"), geometry::InputError);
  robot::Platform driven = stage_pg70();  // by its gripper's `drive`, so that this would be ignored
  driven.hand.motors[0].place = "pg70.yaml:9";
  EXPECT_THROW(carrier_of(driven, "home"), geometry::InputError);
}

TEST(StageArm, FollowsAPathAndStandsAtItsEnd) {
  Stage stage;
  stage.arm.follow(stage.by({0.2, -0.1, 0.05, 0.8}, 1.5), {}, stage.world);
  const robot::Positions start = stage_position(stage.world);
  double off = 0;
  while (stage.arm.drive().status() == ArmDrive::Status::kMoving && stage.world.time() < 3) {
    stage.step();
    off = std::max(off, (stage_position(stage.world) - stage.arm.drive().desired()).norm());
  }
  EXPECT_EQ(stage.arm.drive().status(), ArmDrive::Status::kReached);
  EXPECT_LT(off, 2e-3);
  stage.run(0.1);
  EXPECT_FALSE(stage.arm.moves());
  EXPECT_FALSE(stage.world.carrier().moving);
  const Eigen::Vector4d way = stage_position(stage.world) - start;
  EXPECT_LT((way - Eigen::Vector4d(0.2, -0.1, 0.05, 0.8)).norm(), 1e-9);
  // Whoever moves the carrier then is not hindered, and the next path begins where it stands.
  stage.world.move_carrier(stage.world.scene().carrier.gripper_pose({0, 0, 0.3}, 0), 0.4);
  stage.run(3);
  stage.arm.follow(stage.by({0.05, 0, 0, 0}, 1), {}, stage.world);
  stage.run(1.5);
  EXPECT_NEAR(stage.world.carrier().X_WG.translation().x(), 0.05, 1e-9);
}

TEST(StageArm, BrakesWithinItsAcceleration) {
  Stage stage;
  stage.arm.follow(stage.by({0.4, 0, 0, 0}, 1.6), {}, stage.world);
  stage.run(0.8);
  const double speed = stage.world.carrier().velocity.norm();
  ASSERT_GT(speed, 0.3);
  stage.arm.stop();
  const double before = stage.world.carrier().X_WG.translation().x();
  stage.run(1);
  EXPECT_EQ(stage.arm.drive().status(), ArmDrive::Status::kStopped);
  EXPECT_NEAR(stage.world.carrier().X_WG.translation().x() - before, speed * speed / (2 * 2.0),
              1e-3);
}

// Set points as a controller streams them, a step each 12 ms.
TEST(StageArm, TracksSetPointsWithinItsLimits) {
  for (const bool adaptive : {false, true}) {
    Stage stage(adaptive);
    const robot::Positions from = stage_position(stage.world);
    double fastest = 0;
    for (int k = 1; k <= 125; ++k) {
      robot::Positions goal = from;
      goal[0] += 0.3 * k / 125;  // 0.2 m/s
      stage.arm.track(goal, stage.world);
      stage.run(0.012);
      fastest = std::max(fastest, stage.world.carrier().velocity.norm());
    }
    EXPECT_NEAR(fastest, 0.2, 0.03);
    EXPECT_NEAR(stage_position(stage.world)[0] - from[0], 0.3 - 0.2 * 2 / 30, 5e-3);  // its lag
    stage.run(1.5);
    EXPECT_NEAR(stage_position(stage.world)[0], from[0] + 0.3, 1e-5);
    EXPECT_FALSE(stage.world.carrier().moving);
    // A step is no jump either.
    robot::Positions goal = stage_position(stage.world);
    goal[1] += 0.2;
    stage.arm.track(goal, stage.world);
    const double limit = stage.arm.drive().chain().joints()[1].max_velocity;
    double sharpest = 0;
    for (double before = 0; stage.world.time() < 6;) {
      stage.run(0.01);
      const double speed = stage.world.carrier().velocity.y();
      EXPECT_LE(speed, limit + 1e-9);
      sharpest = std::max(sharpest, std::abs(speed - before) / 0.01);
      before = speed;
    }
    EXPECT_LE(sharpest, 2 * 1.0 * 1.06);  // m/s^2: the platform's, twice over
    EXPECT_NEAR(stage_position(stage.world)[1], goal[1], 1e-5);
  }
}

TEST(StageArm, StopsWhereTheWristFeelsMore) {
  Stage stage;
  const double tip = stage.world.scene().gripper.tip_z();
  const double down = stage_position(stage.world)[2] - (tip - 0.005);
  stage.arm.follow(stage.by({0, 0, -down, 0}, 5), {}, stage.world);
  stage.arm.stop_on_contact(5);
  stage.run(6);
  EXPECT_TRUE(stage.arm.stopped_by_contact());
  EXPECT_EQ(stage.arm.drive().status(), ArmDrive::Status::kStopped);
  EXPECT_GT(stage.world.wrist_wrench().force.norm(), 5);
  EXPECT_GT(stage_position(stage.world)[2], tip - 0.003);
}

TEST(StageArm, RefusesPathsThatCannotBeRight) {
  Stage stage;
  EXPECT_THROW(stage.arm.follow(stage.by({2, 0, 0, 0}, 9), {}, stage.world), std::invalid_argument);
  TrajectoryRequest elsewhere = stage.by({0.1, 0, 0, 0}, 1);
  elsewhere.points[0].position[1] += 0.1;
  EXPECT_THROW(stage.arm.follow(elsewhere, {}, stage.world), std::invalid_argument);
  EXPECT_THROW(stage.world.drive_carrier({1000, 0, 0}, 0), std::invalid_argument);
  EXPECT_THROW(stage.world.drive_carrier({std::nan(""), 0, 0}, 0), std::invalid_argument);
}

// In slices of ten steps the carrier is where the joints are at each slice's end, and between them
// where it is in steps.
TEST(StageArm, AdaptiveStepsFollowTheSamePath) {
  Stage fixed, adaptive{true};
  const Eigen::Vector4d way(0.2, -0.1, 0.05, 0.8);
  for (Stage* stage : {&fixed, &adaptive}) stage->arm.follow(stage->by(way, 1.5), {}, stage->world);
  double between = 0, at_ends = 0;
  for (int slice = 0; slice < 180; ++slice) {
    fixed.run(0.004);
    adaptive.arm.advance(adaptive.world, 4);
    between =
        std::max(between, (stage_position(fixed.world) - stage_position(adaptive.world)).norm());
    fixed.run(0.006);
    adaptive.arm.advance(adaptive.world, 6);
    at_ends =
        std::max(at_ends, (stage_position(fixed.world) - stage_position(adaptive.world)).norm());
  }
  EXPECT_LT(at_ends, 1e-9);
  EXPECT_LT(between, 1e-9);
  EXPECT_FALSE(adaptive.arm.moves());
  EXPECT_FALSE(adaptive.world.carrier().moving);
  EXPECT_EQ(adaptive.arm.drive().status(), ArmDrive::Status::kReached);
}

TEST(StageArm, AdaptiveStepsFeelContactAndStop) {
  Stage fixed, adaptive{true};
  double height[2];
  for (Stage* stage : {&fixed, &adaptive}) {
    const double tip = stage->world.scene().gripper.tip_z();
    const double down = stage_position(stage->world)[2] - (tip - 0.005);
    stage->arm.follow(stage->by({0, 0, -down, 0}, 5), {}, stage->world);
    stage->arm.stop_on_contact(5);
    stage->run(6);
    EXPECT_TRUE(stage->arm.stopped_by_contact());
    height[stage == &adaptive] = stage_position(stage->world)[2];
  }
  EXPECT_NEAR(height[0], height[1], 2e-4) << "at most a few steps later";
}

// What the world was asked is all there is to repeat.
TEST(StageArm, ARecordedRunReplaysBitwise) {
  Stage stage;
  stage.world.record_commands(true);
  stage.arm.follow(stage.by({0.1, 0.05, -0.1, 0.3}, 1), {}, stage.world);
  stage.run(0.7);
  World again(Stage::scene(false));
  replay(read_commands(command_bytes(stage.world.recorded_commands())), stage.world.step_count(),
         again);
  EXPECT_EQ(again.save_bytes(), stage.world.save_bytes());
}

}  // namespace
}  // namespace prehend::simulation
