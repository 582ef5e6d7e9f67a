#include "prehend/control/grasp_cycle.h"

#include <algorithm>
#include <functional>
#include <limits>
#include <numbers>
#include <stdexcept>

#include <gtest/gtest.h>

#include "prehend/control/failed_grasps.h"

namespace prehend::control {
namespace {

using geometry::RigidTransform;

constexpr double kStep = 0.01;  // s

// A gripper, its carrier and one soft object between z = 0 and z = 0.1, enough to drive the cycle.
class FakeWorld {
 public:
  double object_width = 0.05;  // m
  double object_x = 0;         // m; the pads find it within 20 mm
  bool object_is_anywhere = true;
  bool slips_when_lifted = false;
  double obstacle_height = -1;  // m, touched by the approaching hand
  double left_gain = 1, right_gain = 1;
  double finger_stop = 0;  // m, of the opening, where the fingers meet the object beside the pads
  bool frozen_pads = false;
  bool jammed = false;  // the jaws do not move
  bool carrier_stuck = false;

  Percepts percepts() {
    Percepts p;
    p.time = time_;
    p.left = pad(left_gain);
    p.right = pad(right_gain);
    if (frozen_pads) p.left->time = p.right->time = frozen_time_;
    p.opening = opening_;
    p.gripper_blocked = jammed;
    p.wrist_force = touching_obstacle_ ? 10.0 : 0.0;
    p.X_WG = X_WG_;
    return p;
  }

  void advance() {
    time_ += kStep;
    if (!frozen_pads) frozen_time_ = time_;
    move_jaws();
    move_hand();
  }

  const RigidTransform& X_WG() const { return X_WG_; }
  double height() const { return X_WG_.translation().z(); }
  double highest() const { return highest_; }
  double opening() const { return opening_; }
  bool stopped() const { return stopped_; }
  double object_height() const { return object_height_; }
  double highest_object() const { return highest_object_; }

  void move_to(double opening, double speed) {
    opening_target_ = opening;
    jaw_speed_ = speed;
    position_mode_ = true;
    stopped_ = false;
  }
  void command_velocity(double speed, double current_limit) {
    position_mode_ = false;
    stopped_ = false;
    jaw_speed_ = speed;
    current_limit_ = current_limit;
  }
  void move_to(const RigidTransform& X_WG, double speed, double contact_force) {
    target_ = X_WG;
    carrier_speed_ = speed;
    contact_force_ = contact_force;
    contact_ = false;
    carrier_moving_ = true;
  }
  MotionStatus jaw_motion() const {
    if (std::abs(opening_ - opening_target_) < 1e-6) return MotionStatus::kReached;
    return jammed ? MotionStatus::kContact : MotionStatus::kMoving;
  }
  void stop_jaws() { stopped_ = true; }
  MotionStatus carrier_motion() const {
    if (contact_) return MotionStatus::kContact;
    if (carrier_moving_) return MotionStatus::kMoving;
    return MotionStatus::kReached;
  }
  void stop_carrier() { carrier_moving_ = false; }

 private:
  static constexpr double kStiffness = 20000;  // N/m of both pads in series
  bool between() const {
    return height() - object_height_ < 0.1 && object_width > 0 &&
           (object_is_anywhere || std::abs(X_WG_.translation().x() - object_x) < 0.02);
  }
  double force() const {
    return between() && held_possible_ ? std::max(0.0, kStiffness * (object_width - opening_))
                                       : 0.0;
  }
  PadPercept pad(double gain) const {
    const double sum = gain * force();
    return {time_, sum, sum > 0.3 ? 9e-4 : 0};
  }
  void move_jaws() {
    if (stopped_ || jammed) return;
    if (position_mode_) {
      const double step = jaw_speed_ * kStep;
      opening_ += std::clamp(opening_target_ - opening_, -step, step);
    } else {
      // Blocked where the drive's force, less its friction, meets the spring's.
      const double push = std::max(0.0, 30 * current_limit_ - 8);
      const double equilibrium = between() && held_possible_ ? object_width - push / kStiffness : 0;
      opening_ = std::max({opening_ + jaw_speed_ * kStep, equilibrium, finger_stop});
    }
  }
  void move_hand() {
    if (!carrier_moving_ || carrier_stuck) return;
    const Eigen::Vector3d left = target_.translation() - X_WG_.translation();
    const double step = carrier_speed_ * kStep;
    const bool gripped = force() > 1;
    const Eigen::Vector3d move =
        left.norm() <= step ? left : Eigen::Vector3d(step * left.normalized());
    X_WG_.translation() += move;
    X_WG_.linear() = target_.linear();
    if (left.norm() <= step) carrier_moving_ = false;
    if (gripped) object_height_ = std::max(0.0, object_height_ + move.z());
    if (gripped) object_x += move.x();
    if (slips_when_lifted && object_height_ > 0.05) {
      held_possible_ = false;
      object_height_ = 0;
    }
    if (!gripped || force() == 0) object_height_ = 0;
    touching_obstacle_ = height() < obstacle_height;
    if (contact_force_ > 0 && touching_obstacle_) {
      contact_ = true;
      carrier_moving_ = false;
    }
    highest_ = std::max(highest_, height());
    highest_object_ = std::max(highest_object_, object_height_);
  }

  double time_ = 100, frozen_time_ = 100;
  double opening_ = 0.03, opening_target_ = 0.03, jaw_speed_ = 0, current_limit_ = 0;
  bool position_mode_ = true, stopped_ = false, held_possible_ = true;
  RigidTransform X_WG_ = geometry::make_transform(Eigen::Quaterniond(0, 1, 0, 0), {-0.3, 0, 0.4});
  RigidTransform target_ = X_WG_;
  double carrier_speed_ = 0, contact_force_ = 0;
  bool carrier_moving_ = false, contact_ = false, touching_obstacle_ = false;
  double object_height_ = 0, highest_object_ = 0, highest_ = 0;
};

struct FakeGripper : GripperPort {
  explicit FakeGripper(FakeWorld& world) : world_(world) {}
  void move_to(double opening, double speed) override { world_.move_to(opening, speed); }
  MotionStatus motion() override { return world_.jaw_motion(); }
  void command_velocity(double speed, double limit) override {
    world_.command_velocity(speed, limit);
  }
  void stop() override { world_.stop_jaws(); }
  FakeWorld& world_;
};

struct FakeCarrier : CarrierPort {
  explicit FakeCarrier(FakeWorld& world) : world_(world) {}
  void move_to(const RigidTransform& X_WG, double speed, double force) override {
    world_.move_to(X_WG, speed, force);
  }
  MotionStatus motion() override { return world_.carrier_motion(); }
  void stop() override { world_.stop_carrier(); }
  FakeWorld& world_;
};

grasp::Grasp grasp_at(double x) {
  grasp::Grasp grasp;
  grasp.X_WG = geometry::make_transform(Eigen::Quaterniond(0, 1, 0, 0), {x, 0, 0.04});
  grasp.pregrasp_opening = 0.069;
  grasp.pregrasp_distance = 0.08;
  grasp.grasp_force = 12;
  grasp.predicted = {0.05, 9e-4, 12, 0.2};
  return grasp;
}

class GraspCycleTest : public testing::Test {
 protected:
  // Runs to the end, at most 200 simulated seconds.
  void run(
      int grasps, const std::function<void()>& each_step = [] {}) {
    std::vector<grasp::Grasp> list;
    for (int i = 0; i < grasps; ++i) list.push_back(grasp_at(0.01 * i));
    cycle.start(list);
    for (int i = 0; i < 20000 && !cycle.finished(); ++i) {
      each_step();
      cycle.step(world.percepts());
      world.advance();
    }
    EXPECT_TRUE(cycle.finished()) << cycle.detail();
  }
  const Surprise* surprise(SurpriseKind kind) const {
    const auto found = std::find_if(cycle.surprises().begin(), cycle.surprises().end(),
                                    [kind](const Surprise& s) { return s.kind == kind; });
    return found == cycle.surprises().end() ? nullptr : &*found;
  }

  FakeWorld world;
  FakeGripper gripper{world};
  FakeCarrier carrier{world};
  GraspCycle cycle{robot::GripperModel{}, CycleOptions{}, gripper, carrier};
};

TEST_F(GraspCycleTest, GraspsLiftsMovesAndReleases) {
  run(3);
  EXPECT_TRUE(cycle.result().success) << cycle.result().reason;
  EXPECT_EQ(cycle.result().attempts, 1);
  EXPECT_EQ(cycle.result().grasp_index, 0);
  EXPECT_GE(world.highest_object(), 0.12);
  EXPECT_EQ(world.object_height(), 0);
  EXPECT_NEAR(world.opening(), 0.069, 1e-6);
  for (auto kind : {SurpriseKind::kOpeningAtContact, SurpriseKind::kContactArea,
                    SurpriseKind::kTactileSum, SurpriseKind::kHeldAfterLift}) {
    ASSERT_NE(surprise(kind), nullptr);
    EXPECT_FALSE(surprise(kind)->surprising) << static_cast<int>(kind);
  }
  std::vector<std::string> phases;
  for (const auto& [phase, seconds] : cycle.phase_times()) phases.push_back(phase);
  EXPECT_EQ(phases,
            (std::vector<std::string>{"waiting", "approach", "grasp", "lift", "move", "release"}));
}

TEST_F(GraspCycleTest, WrongWidthIsASurpriseButGripped) {
  world.object_width = 0.035;
  run(1);
  EXPECT_TRUE(cycle.result().success) << cycle.result().reason;
  ASSERT_NE(surprise(SurpriseKind::kOpeningAtContact), nullptr);
  EXPECT_TRUE(surprise(SurpriseKind::kOpeningAtContact)->surprising);
  EXPECT_NEAR(surprise(SurpriseKind::kOpeningAtContact)->felt, 0.035, 1e-3);
}

TEST_F(GraspCycleTest, NothingThereTriesTheNextGrasps) {
  world.object_width = 0;
  run(5);
  EXPECT_FALSE(cycle.result().success);
  EXPECT_EQ(cycle.result().attempts, 3);
  EXPECT_NE(cycle.result().reason.find("neither pad"), std::string::npos) << cycle.result().reason;
}

TEST_F(GraspCycleTest, SlippedObjectIsNoticedAfterTheLift) {
  world.slips_when_lifted = true;
  run(1);
  EXPECT_FALSE(cycle.result().success);
  ASSERT_NE(surprise(SurpriseKind::kHeldAfterLift), nullptr);
  EXPECT_TRUE(surprise(SurpriseKind::kHeldAfterLift)->surprising);
  EXPECT_NE(cycle.result().reason.find("not held"), std::string::npos) << cycle.result().reason;
}

// Once grasps that held well were let go, as a finger met the object beside its pad.
TEST_F(GraspCycleTest, LiftsWithLessForceThanAskedForWhenThePadsGetNoMore) {
  world.finger_stop = 0.05 - 8.0 / 20000;  // 8 N of 12
  run(1);
  EXPECT_TRUE(cycle.result().success) << cycle.result().reason;
  EXPECT_GE(world.highest_object(), 0.12);
}

TEST_F(GraspCycleTest, GivesUpWithMuchLessForceThanAskedFor) {
  world.finger_stop = 0.05 - 5.0 / 20000;
  run(1);
  EXPECT_FALSE(cycle.result().success);
  EXPECT_NE(cycle.result().reason.find("force was not reached"), std::string::npos)
      << cycle.result().reason;
}

TEST_F(GraspCycleTest, EarlyTouchBacksOff) {
  world.obstacle_height = 0.08;
  run(2);
  EXPECT_FALSE(cycle.result().success);
  EXPECT_EQ(cycle.result().attempts, 2);
  ASSERT_NE(surprise(SurpriseKind::kTouchedTooEarly), nullptr);
  EXPECT_GT(world.height(), 0.12);
}

TEST_F(GraspCycleTest, OneNumbPad) {
  world.right_gain = 0;
  run(1);
  EXPECT_FALSE(cycle.result().success);
  EXPECT_NE(cycle.result().reason.find("only the left pad"), std::string::npos)
      << cycle.result().reason;
}

TEST_F(GraspCycleTest, StaleTactileDataStopTheGripper) {
  run(3, [&] {
    if (cycle.phase() == Phase::kLift) world.frozen_pads = true;
  });
  EXPECT_FALSE(cycle.result().success);
  EXPECT_NE(cycle.result().reason.find("stale"), std::string::npos) << cycle.result().reason;
  EXPECT_TRUE(world.stopped());
}

TEST_F(GraspCycleTest, JammedGripperGivesUp) {
  world.jammed = true;
  run(1);
  EXPECT_NE(cycle.result().reason.find("does not open"), std::string::npos)
      << cycle.result().reason;
}

TEST_F(GraspCycleTest, StuckCarrierTimesOut) {
  world.carrier_stuck = true;
  run(1);
  EXPECT_FALSE(cycle.result().success);
  EXPECT_NE(cycle.result().reason.find("timed out"), std::string::npos) << cycle.result().reason;
}

TEST_F(GraspCycleTest, EmptyPlanEndsWithItsReason) {
  cycle.start({}, "cannot be grasped: narrowest width 94 mm exceeds the gripper's 69 mm");
  EXPECT_TRUE(cycle.finished());
  EXPECT_FALSE(cycle.result().success);
  EXPECT_EQ(cycle.result().reason,
            "cannot be grasped: narrowest width 94 mm exceeds the gripper's 69 mm");
}

TEST_F(GraspCycleTest, SilentDevicesTimeOut) {
  cycle.start({grasp_at(0)});
  Percepts nothing;
  for (int i = 0; i < 10000 && !cycle.finished(); ++i) {
    nothing.time = 5 + i * kStep;
    cycle.step(nothing);
  }
  EXPECT_TRUE(cycle.finished());
  EXPECT_NE(cycle.result().reason.find("no state came"), std::string::npos);
}

TEST_F(GraspCycleTest, CanStartAgain) {
  run(1);
  ASSERT_TRUE(cycle.result().success);
  run(1);
  EXPECT_TRUE(cycle.result().success) << cycle.result().reason;
  EXPECT_EQ(cycle.result().attempts, 1);
}

TEST_F(GraspCycleTest, AbortStops) {
  cycle.start({grasp_at(0)});
  for (int i = 0; i < 50; ++i) {
    cycle.step(world.percepts());
    world.advance();
  }
  cycle.abort("told to");
  EXPECT_TRUE(cycle.finished());
  EXPECT_TRUE(world.stopped());
  EXPECT_EQ(cycle.result().reason, "told to");
}

// The cycle that looks again, for at most 5 s.
class LookingCycleTest : public GraspCycleTest {
 protected:
  static CycleOptions options() {
    CycleOptions o;
    o.look_timeout = 5;
    return o;
  }
  void run_until_it_looks(GraspCycle* driven) {
    for (int i = 0; i < 20000 && !driven->finished() && !driven->looks_since(); ++i) {
      driven->step(world.percepts());
      world.advance();
    }
    ASSERT_TRUE(driven->looks_since()) << driven->detail();
  }
  void run_to_the_end(GraspCycle* driven) {
    for (int i = 0; i < 20000 && !driven->finished(); ++i) {
      driven->step(world.percepts());
      world.advance();
    }
    ASSERT_TRUE(driven->finished()) << driven->detail();
  }
  GraspCycle looking{robot::GripperModel{}, options(), gripper, carrier};
};

// Once the second attempt closed on nothing too: the first one had pushed the object aside.
TEST_F(LookingCycleTest, TakesAPlanOfWhereTheObjectIsNow) {
  world.object_is_anywhere = false;
  world.object_x = 0.06;
  const RigidTransform start = world.X_WG();
  looking.start({grasp_at(0), grasp_at(0.01), grasp_at(-0.01)});
  run_until_it_looks(&looking);
  EXPECT_TRUE(world.X_WG().translation().isApprox(start.translation(), 1e-6))
      << "it stands in the camera's view";
  EXPECT_NEAR(*looking.looks_since(), world.percepts().time, 0.05);
  looking.take_plan({grasp_at(0.06)}, {0.1, 0, 0});
  EXPECT_FALSE(looking.looks_since());
  run_to_the_end(&looking);
  EXPECT_TRUE(looking.result().success) << looking.result().reason;
  EXPECT_EQ(looking.result().attempts, 2);
  EXPECT_EQ(looking.result().plans, 2);
  EXPECT_EQ(looking.result().grasp_index, 0);
  EXPECT_NEAR(looking.grasp().X_WG.translation().x(), 0.06, 1e-12);
  EXPECT_NEAR(world.X_WG().translation().x(), 0.16, 1e-6) << "not carried by the new plan's way";
}

TEST_F(LookingCycleTest, WithoutANewPlanTakesTheNextGrasp) {
  world.object_is_anywhere = false;
  world.object_x = 0.05;
  looking.start({grasp_at(0), grasp_at(0.002), grasp_at(0.05)});
  run_until_it_looks(&looking);
  const double since = *looking.looks_since();
  bool said = false;
  for (int i = 0; i < 20000 && !looking.finished(); ++i) {
    looking.step(world.percepts());
    said = said || looking.detail().find("no new plan came") != std::string::npos;
    if (!looking.looks_since()) break;
    world.advance();
  }
  EXPECT_NEAR(world.percepts().time - since, options().look_timeout, 0.05);
  EXPECT_TRUE(said);
  run_to_the_end(&looking);
  EXPECT_TRUE(looking.result().success) << looking.result().reason;
  EXPECT_EQ(looking.result().grasp_index, 2) << "2 mm beside the one that failed";
  EXPECT_EQ(looking.result().plans, 1);
}

TEST_F(LookingCycleTest, AnEmptyNewPlanIsSaidAndTheOldOneGoesOn) {
  world.object_width = 0;
  looking.start({grasp_at(0)});
  run_until_it_looks(&looking);
  looking.take_plan({}, {0, 0.1, 0}, "cannot be grasped: too wide");
  EXPECT_TRUE(looking.finished());
  EXPECT_NE(looking.result().reason.find("too wide"), std::string::npos) << looking.result().reason;
}

TEST_F(LookingCycleTest, WhatFailedIsTriedLastThoughItIsPlannedAgain) {
  world.object_is_anywhere = false;
  world.object_x = 0.04;
  looking.start({grasp_at(0)});
  run_until_it_looks(&looking);
  looking.take_plan({grasp_at(0.003), grasp_at(0.04)}, {0, 0.1, 0});
  run_to_the_end(&looking);
  EXPECT_TRUE(looking.result().success) << looking.result().reason;
  EXPECT_EQ(looking.result().attempts, 2);
  EXPECT_EQ(looking.result().grasp_index, 1);
}

TEST_F(LookingCycleTest, GivesUpAfterTheLastAttemptWithoutLooking) {
  world.object_width = 0;
  looking.start({grasp_at(0)});
  for (int attempt = 1; attempt < options().largest_attempts; ++attempt) {
    run_until_it_looks(&looking);
    looking.take_plan({grasp_at(0.05 * attempt)}, {0, 0.1, 0});
  }
  run_to_the_end(&looking);
  EXPECT_FALSE(looking.result().success);
  EXPECT_EQ(looking.result().attempts, options().largest_attempts);
  looking.take_plan({grasp_at(0)}, {0, 0.1, 0});
  EXPECT_TRUE(looking.finished()) << "a plan that nobody waits for";
}

TEST(FailedGrasps, AreLikeOthersWithinMillimetresAndTurnedByHalf) {
  const grasp::Grasp grasp = grasp_at(0);
  EXPECT_TRUE(is_like(grasp, grasp_at(0.005)));
  EXPECT_FALSE(is_like(grasp, grasp_at(0.007)));
  grasp::Grasp turned = grasp;
  turned.X_WG.rotate(Eigen::AngleAxisd(std::numbers::pi, Eigen::Vector3d::UnitZ()));
  EXPECT_TRUE(is_like(grasp, turned));
  turned.X_WG.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitZ()));
  EXPECT_FALSE(is_like(grasp, turned));
  turned = grasp;
  turned.X_WG.rotate(Eigen::AngleAxisd(0.2, Eigen::Vector3d::UnitX()));
  EXPECT_FALSE(is_like(grasp, turned));
  EXPECT_EQ(next_to_try({}, {}, {}), std::nullopt);
  EXPECT_EQ(next_to_try({grasp, grasp_at(0.05)}, {false, false}, {grasp}), 1u);
  EXPECT_EQ(next_to_try({grasp, grasp_at(0.05)}, {false, true}, {grasp}), 0u);
  EXPECT_EQ(next_to_try({grasp}, {true}, {grasp}), std::nullopt);
}

TEST(CycleOptions, AreChecked) {
  FakeWorld world;
  FakeGripper gripper(world);
  FakeCarrier carrier(world);
  CycleOptions options;
  options.lift_height = 0.05;
  EXPECT_THROW(GraspCycle(robot::GripperModel{}, options, gripper, carrier), std::invalid_argument);
}

TEST(Surprise, NanSurprises) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(compare(SurpriseKind::kTactileSum, 10, nan, {}, "stop").surprising);
  EXPECT_EQ(compare(SurpriseKind::kTactileSum, 10, nan, {}, "stop").reaction, "stop");
}

TEST(Surprise, TakesTheLargerTolerance) {
  SurpriseTolerances tolerances;
  EXPECT_FALSE(compare(SurpriseKind::kTactileSum, 10, 11.9, tolerances, "x").surprising);
  EXPECT_TRUE(compare(SurpriseKind::kTactileSum, 10, 12.1, tolerances, "x").surprising);
  EXPECT_FALSE(compare(SurpriseKind::kTactileSum, 1, 1.9, tolerances, "x").surprising);
  EXPECT_TRUE(compare(SurpriseKind::kHeldAfterLift, 1, 0, tolerances, "x").surprising);
  EXPECT_FALSE(compare(SurpriseKind::kHeldAfterLift, 1, 1, tolerances, "x").surprising);
  tolerances.area = -1;
  EXPECT_THROW(tolerances.validate(), std::invalid_argument);
}

}  // namespace
}  // namespace prehend::control
