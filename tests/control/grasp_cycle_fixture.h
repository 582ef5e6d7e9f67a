#pragma once

#include <algorithm>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "prehend/control/grasp_cycle.h"

namespace prehend::control {

using geometry::RigidTransform;

inline constexpr double kStep = 0.01;  // s

// A gripper, its carrier and one soft object between z = 0 and z = 0.1, enough to drive the cycle.
class FakeWorld {
 public:
  double object_width = 0.05;  // m
  double object_x = 0;         // m; the pads find it within 20 mm
  bool object_is_anywhere = true;
  bool slips_when_lifted = false;
  bool lost_when_carried = false;
  double obstacle_height = -1;  // m, touched by the approaching hand
  double left_gain = 1, right_gain = 1;
  double finger_stop = 0;  // m, of the opening, where the fingers meet the object beside the pads
  bool jammed = false;     // the jaws do not move
  bool carrier_stuck = false;

  Percepts percepts() {
    Percepts p;
    p.time = time_;
    p.left = is_silent("left") ? silent_.at("left").left : pad(left_gain);
    p.right = is_silent("right") ? silent_.at("right").right : pad(right_gain);
    p.opening = is_silent("gripper") ? silent_.at("gripper").opening : opening_;
    p.gripper_blocked = jammed;
    p.wrist_force = touching_obstacle_ ? 10.0 : 0.0;
    p.X_WG = is_silent("carrier") ? silent_.at("carrier").X_WG : X_WG_;
    if (p.left) p.left->age = age("left");
    if (p.right) p.right->age = age("right");
    p.gripper_age = age("gripper");
    p.wrist_age = age("wrist");
    p.carrier_age = age("carrier");
    return p;
  }

  /// From now on nothing comes from it: "left", "right" (pads), "gripper", "wrist", "carrier",
  /// "gripper motion", "carrier motion" (their servers).
  void silence(const std::string& input) { silent_.try_emplace(input, percepts()); }
  bool is_silent(const std::string& input) const { return silent_.count(input) > 0; }
  double age(const std::string& input) const {  // s
    return is_silent(input) ? time_ - silent_.at(input).time : 0;
  }

  void advance() {
    time_ += kStep;
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
    if (is_silent("gripper motion")) return MotionStatus::kMoving;
    if (std::abs(opening_ - opening_target_) < 1e-6) return MotionStatus::kReached;
    return jammed ? MotionStatus::kContact : MotionStatus::kMoving;
  }
  void stop_jaws() { stopped_ = true; }
  bool carrier_moving() const { return carrier_moving_; }
  MotionStatus carrier_motion() const {
    if (is_silent("carrier motion")) return MotionStatus::kMoving;
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
    return {sum, sum > 0.3 ? 9e-4 : 0};
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
    if (lost_when_carried && gripped && X_WG_.translation().y() > 0.05) held_possible_ = false;
    if (!gripped || force() == 0) object_height_ = 0;
    touching_obstacle_ = height() < obstacle_height;
    if (contact_force_ > 0 && touching_obstacle_) {
      contact_ = true;
      carrier_moving_ = false;
    }
    highest_ = std::max(highest_, height());
    highest_object_ = std::max(highest_object_, object_height_);
  }

  double time_ = 100;
  std::map<std::string, Percepts> silent_;  // input -> what was known when it fell silent
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
  double answer_age() override { return world_.age("gripper motion"); }
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
  double answer_age() override { return world_.age("carrier motion"); }
  void stop() override { world_.stop_carrier(); }
  FakeWorld& world_;
};

inline grasp::Grasp grasp_at(double x) {
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

}  // namespace prehend::control
