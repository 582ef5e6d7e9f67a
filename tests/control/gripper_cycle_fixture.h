#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/control/arm_cycle.h"
#include "prehend/control/pad_gripper.h"

namespace prehend::control {

using geometry::RigidTransform;

inline constexpr double kStep = 0.01;  // s

// A parallel gripper, the stage that carries it and one soft object between z = 0 and z = 0.1,
// enough to drive the cycle.
class FakeWorld {
 public:
  double object_width = 0.05;  // m
  double object_x = 0;         // m; the pads find it within 20 mm
  bool object_is_anywhere = true;
  bool slips_when_lifted = false;
  bool lost_when_carried = false;
  double obstacle_height = -1;  // m, touched by the approaching hand
  double left_gain = 1, right_gain = 1;
  double needed_force = 0;   // N: with less it slides through the pads when it is lifted
  double finger_stop = 0;    // m, of the opening, where the fingers meet the object beside the pads
  double wedged_below = -1;  // m, of the hand: the left pad touches the object on the approach
  bool jammed = false;       // the jaws do not move
  bool refuses_to_open = false;  // at the place: who moves them says no
  /// m, of the hand, 0.1 m beside where the object stood: below it the jaws open no farther.
  double jam_height = -1, jam_opening = 0;
  bool arm_stuck = false;

  ArmPercepts percepts() {
    ArmPercepts p;
    p.time = time_;
    p.names = {"x", "y", "z"};
    const Eigen::Vector3d at = is_silent("joints") ? silent_.at("joints").p_WG : p_WG_;
    p.positions = {at.x(), at.y(), at.z()};
    p.joints_age = age("joints");
    p.wrist_force = Eigen::Vector3d(0, 0, touching_obstacle_ ? 10 : 0);
    p.wrist_age = age("wrist");
    for (const auto& [name, gain] :
         {std::pair("left", left_gain), std::pair("right", right_gain)}) {
      PadPercept felt = is_silent(name) ? silent_.at(name).pad : pad(gain);
      const bool wedged = height() < wedged_below && name == std::string("left") &&
                          opening_ > object_width && object_height_ == 0;
      if (wedged) felt = {8, 1e-4};
      felt.age = age(name);
      felt.name = name;
      p.pads.push_back(felt);
      if (needed_force > 0) p.frames.push_back({name, felt_, pattern(felt.sum)});
    }
    const double opening = is_silent("gripper") ? silent_.at("gripper").opening : opening_;
    p.gripper = GripperPercept{opening, jammed, 0, age("gripper")};
    return p;
  }

  /// From now on nothing comes from it: "left", "right" (pads), "gripper", "wrist", "joints",
  /// "gripper motion", "arm motion" (their servers).
  void silence(const std::string& input) {
    silent_.try_emplace(
        input, Known{time_, opening_, p_WG_, pad(input == "left" ? left_gain : right_gain)});
  }
  bool is_silent(const std::string& input) const { return silent_.count(input) > 0; }
  double age(const std::string& input) const {  // s
    return is_silent(input) ? time_ - silent_.at(input).time : 0;
  }

  void advance() {
    time_ += kStep;
    move_jaws();
    move_hand();
  }

  const Eigen::Vector3d& p_WG() const { return p_WG_; }
  double height() const { return p_WG_.z(); }
  double highest() const { return highest_; }
  double opening() const { return opening_; }
  bool stopped() const { return stopped_; }
  double object_height() const { return object_height_; }
  double highest_object() const { return highest_object_; }
  double slid() const { return slid_; }  // m

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
  void follow(const JointTrajectory& path, double contact_force) {
    path_ = path;
    path_begin_ = time_;
    contact_force_ = contact_force;
    contact_ = false;
    begins_in_obstacle_ = height() < obstacle_height;
    arm_moving_ = true;
  }
  MotionStatus jaw_motion() const {
    if (is_silent("gripper motion")) return MotionStatus::kMoving;
    if (refuses_to_open && p_WG_.y() > 0.1) return MotionStatus::kFailed;
    if (std::abs(opening_ - opening_target_) < 1e-6) return MotionStatus::kReached;
    return jammed || is_jammed_beside() ? MotionStatus::kContact : MotionStatus::kMoving;
  }
  void stop_jaws() { stopped_ = true; }
  bool arm_moving() const { return arm_moving_; }
  MotionStatus arm_motion() const {
    if (is_silent("arm motion")) return MotionStatus::kMoving;
    if (contact_) return MotionStatus::kContact;
    return arm_moving_ ? MotionStatus::kMoving : MotionStatus::kReached;
  }
  void stop_arm() { arm_moving_ = false; }

 private:
  struct Known {
    double time = 0, opening = 0;  // s, m
    Eigen::Vector3d p_WG;
    PadPercept pad;
  };
  static constexpr double kStiffness = 20000;  // N/m of both pads in series
  bool between() const {
    return height() - object_height_ < 0.1 && object_width > 0 &&
           (object_is_anywhere || std::abs(p_WG_.x() - object_x) < 0.02);
  }
  double force() const {
    return between() && held_possible_ ? std::max(0.0, kStiffness * (object_width - opening_))
                                       : 0.0;
  }
  // Of a round thing, as far along the fingers as it has slid.
  std::vector<double> pattern(double sum) const {
    std::vector<double> counts;
    for (std::size_t i = 0; i < felt_->layout.size(); ++i) {
      const double x = felt_->layout.x[i], y = felt_->layout.y[i] + slid_;
      counts.push_back(50 * sum * std::exp(-(x * x + y * y) / (2 * 0.0065 * 0.0065)));
    }
    return counts;
  }
  PadPercept pad(double gain) const {
    const double sum = gain * force();
    return {sum, sum > 0.3 ? 9e-4 : 0};
  }
  bool is_jammed_beside() const {
    return position_mode_ && p_WG_.y() > 0.1 && height() < jam_height && opening_ >= jam_opening;
  }
  void move_jaws() {
    if (stopped_ || jammed || is_jammed_beside()) return;
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
    if (!arm_moving_ || arm_stuck) return;
    const bool gripped = force() > 1;
    const double since = time_ - path_begin_;
    const Eigen::Vector3d before = p_WG_;
    p_WG_ = on_path(since);
    const Eigen::Vector3d move = p_WG_ - before;
    if (since >= path_.points.back().time) arm_moving_ = false;
    if (gripped && move.z() > 0 && force() < needed_force) slid_ += kSlideSpeed * kStep;
    if (gripped) object_height_ = std::max(0.0, object_height_ + move.z());
    if (gripped) object_x += move.x();
    if (slips_when_lifted && object_height_ > 0.05) {
      held_possible_ = false;
      object_height_ = 0;
    }
    if (lost_when_carried && gripped && p_WG_.y() > 0.05) held_possible_ = false;
    if (!gripped || force() == 0) object_height_ = 0;
    touching_obstacle_ = height() < obstacle_height;
    if (contact_force_ > 0 && touching_obstacle_ && !begins_in_obstacle_) {
      contact_ = true;
      arm_moving_ = false;
    }
    highest_ = std::max(highest_, height());
    highest_object_ = std::max(highest_object_, object_height_);
  }

  // Straight between points.
  Eigen::Vector3d on_path(double time) const {
    const auto at = [](const JointTrajectory::Point& point) {
      return Eigen::Vector3d(point.position[0], point.position[1], point.position[2]);
    };
    for (std::size_t i = 1; i < path_.points.size(); ++i) {
      const auto &from = path_.points[i - 1], &to = path_.points[i];
      if (time > to.time) continue;
      return at(from) + (time - from.time) / (to.time - from.time) * (at(to) - at(from));
    }
    return at(path_.points.back());
  }

  static constexpr double kSlideSpeed = 0.01;  // m/s
  std::shared_ptr<const touch::FeltPad> felt_ =
      std::make_shared<touch::FeltPad>(touch::felt_pad(robot::TactilePadModel()));
  double slid_ = 0;  // m
  double time_ = 100;
  std::map<std::string, Known> silent_;  // input -> what was known when it fell silent
  double opening_ = 0.03, opening_target_ = 0.03, jaw_speed_ = 0, current_limit_ = 0;
  bool position_mode_ = true, stopped_ = false, held_possible_ = true;
  Eigen::Vector3d p_WG_{-0.3, 0, 0.4};
  JointTrajectory path_;
  double path_begin_ = 0, contact_force_ = 0;
  bool arm_moving_ = false, contact_ = false, touching_obstacle_ = false;
  bool begins_in_obstacle_ = false;  // what presses at first is allowed for
  double object_height_ = 0, highest_object_ = 0, highest_ = 0;
};

struct FakeDrive : GripperPort {
  explicit FakeDrive(FakeWorld& world) : world_(world) {}
  void move_to(double opening, double speed) override { world_.move_to(opening, speed); }
  MotionStatus motion() override { return world_.jaw_motion(); }
  double answer_age() override { return world_.age("gripper motion"); }
  void command_velocity(double speed, double limit) override {
    world_.command_velocity(speed, limit);
  }
  void stop() override { world_.stop_jaws(); }
  FakeWorld& world_;
};

struct FakeStage : ArmPort {
  explicit FakeStage(FakeWorld& world) : world_(world) {}
  void follow(const JointTrajectory& path, double force) override { world_.follow(path, force); }
  MotionStatus motion() override { return world_.arm_motion(); }
  double answer_age() override { return world_.age("arm motion"); }
  std::string problem() override { return "the stage's words"; }
  void stop() override { world_.stop_arm(); }
  FakeWorld& world_;
};

/// A grasp of the object at x [m], from where FakeWorld's stage stands at first; the object is
/// carried by `move` [m], and put down from `height` [m].
inline ArmGrasp grasp_at(double x, const Eigen::Vector3d& move = {0, 0.15, 0},
                         double height = 0.15) {
  ArmGrasp grasp;
  grasp.pose.X_WG = geometry::make_transform(Eigen::Quaterniond(0, 1, 0, 0), {x, 0, 0.04});
  Eigen::Vector3d here(-0.3, 0, 0.4);
  const auto add = [&](motion::SegmentKind kind, const Eigen::Vector3d& to, double speed) {
    const auto point = [](double time, const Eigen::Vector3d& p) {
      return JointTrajectory::Point{time, {p.x(), p.y(), p.z()}, {0, 0, 0}, {}};
    };
    grasp.segments.push_back(
        {kind, {{"x", "y", "z"}, {point(0, here), point((to - here).norm() / speed, to)}}});
    here = to;
  };
  using motion::SegmentKind;
  const Eigen::Vector3d at(x, 0, 0.04), up(0, 0, height), back(0, 0, 0.08);
  add(SegmentKind::kReach, at + back, 0.25);
  add(SegmentKind::kApproach, at, 0.08);
  grasp.approach_length = 0.08;
  add(SegmentKind::kLift, at + up, 0.1);
  add(SegmentKind::kCarry, at + up + move, 0.25);
  add(SegmentKind::kPlace, at + move, 0.08);
  grasp.place_length = height;
  add(SegmentKind::kRetreat, at + move + back, 0.25);
  grasp.hand_joints = {"opening"};
  const auto one = [](double value) { return Eigen::VectorXd::Constant(1, value); };
  grasp.hand = {one(0.0345), one(0.025), one(-0.1), one(0), one(0.0345)};
  grasp.force = 12;
  grasp.contact_area = 9e-4;
  grasp.tactile_sum = 12;
  grasp.lifted_mass = 0.2;
  return grasp;
}

inline ArmCycleOptions reacting() {
  ArmCycleOptions options;
  options.reacts = true;
  options.motion_timeout = 20;
  return options;
}

class GripperCycleTest : public testing::Test {
 protected:
  // Runs to the end, at most 200 simulated seconds.
  void run(
      int grasps, const std::function<void()>& each_step = [] {}) {
    std::vector<ArmGrasp> list;
    for (int i = 0; i < grasps; ++i) list.push_back(grasp_at(0.01 * i));
    cycle.start(list);
    for (int i = 0; i < 20000 && !cycle.finished(); ++i) {
      each_step();
      cycle.step(world.percepts());
      world.advance();
    }
    EXPECT_TRUE(cycle.finished()) << cycle.detail();
  }
  void run_to_the_end(ArmCycle& driven) {
    for (int i = 0; i < 60000 && !driven.finished(); ++i) {
      driven.step(world.percepts());
      world.advance();
    }
    ASSERT_TRUE(driven.finished()) << driven.detail();
  }
  const Surprise* surprise(SurpriseKind kind) const {
    const auto found = std::find_if(cycle.surprises().begin(), cycle.surprises().end(),
                                    [kind](const Surprise& s) { return s.kind == kind; });
    return found == cycle.surprises().end() ? nullptr : &*found;
  }

  FakeWorld world;
  FakeDrive drive{world};
  FakeStage arm{world};
  PadGripper hand{robot::GripperModel{}, {}, drive};
  ArmCycle cycle{reacting(), arm, hand};
};

}  // namespace prehend::control
