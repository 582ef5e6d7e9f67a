#include "prehend/control/stage_in_world.h"

#include <cmath>
#include <stdexcept>

namespace prehend::control {

using simulation::GripperMode;

namespace {

constexpr double kOpeningTolerance = 3e-4;  // m

}  // namespace

void WorldGripper::move_to(double opening, double speed) {
  target_ = opening;
  refused_ = !(speed > 0);
  if (refused_) return;
  try {
    world_.set_gripper_command(GripperMode::kPosition, opening, 0, speed);
  } catch (const std::invalid_argument&) {
    refused_ = true;
  }
}

MotionStatus WorldGripper::motion() {
  if (refused_) return MotionStatus::kFailed;
  const simulation::GripperReading now = world_.gripper();
  if (std::abs(now.opening - target_) < kOpeningTolerance && !now.moving) {
    return MotionStatus::kReached;
  }
  return now.blocked ? MotionStatus::kContact : MotionStatus::kMoving;
}

void WorldGripper::command_velocity(double speed, double current_limit) {
  world_.set_gripper_command(GripperMode::kVelocity, speed, current_limit);
}

void WorldGripper::stop() { world_.set_gripper_command(GripperMode::kStop, 0); }

StageInWorld::StageInWorld(simulation::World& world, const robot::Platform& platform,
                           const std::string& home, const PadGripperOptions& gripper)
    : world_(world),
      stage_(platform, home),
      arm_(*this),
      drive_(world),
      hand_(world.scene().gripper, gripper, drive_),
      left_(std::make_shared<touch::FeltPad>(touch::felt_pad(world.scene().gripper.pad))),
      right_(std::make_shared<touch::FeltPad>(touch::felt_pad(world.scene().gripper.pad, true))) {}

void StageInWorld::advance(int steps) {
  for (std::int64_t left = steps; left > 0;) left -= stage_.advance(world_, left);
}

void StageInWorld::follow(const simulation::TrajectoryRequest& request, double contact_force) {
  try {
    stage_.follow(request, {}, world_);
    stage_.stop_on_contact(contact_force);
  } catch (const std::invalid_argument&) {
    stage_.let_go();
    throw;
  }
}

ArmPercepts StageInWorld::percepts(int touch_counts) {
  ArmPercepts percepts;
  percepts.time = world_.time();
  const robot::Positions q = simulation::stage_position(world_);
  percepts.positions.assign(q.begin(), q.end());
  for (const robot::ChainJoint& joint : stage_.drive().chain().joints()) {
    percepts.names.push_back(joint.name);
  }
  const auto wrench = world_.wrist_wrench();
  percepts.wrist_force = wrench.force;
  percepts.wrist_torque = wrench.torque;
  for (const auto side : {simulation::PadSide::kLeft, simulation::PadSide::kRight}) {
    const bool left = side == simulation::PadSide::kLeft;
    const auto& felt = left ? left_ : right_;
    const simulation::TactileImage image = world_.tactile_image(side);
    const std::string name = left ? "left" : "right";
    percepts.pads.push_back(
        {image.sum, robot::touched_area(image.counts, touch_counts, felt->layout), 0, name});
    percepts.frames.push_back({name, felt, {image.counts.begin(), image.counts.end()}});
  }
  const simulation::GripperReading gripper = world_.gripper();
  percepts.gripper = {gripper.opening, gripper.blocked, 0, 0};
  return percepts;
}

}  // namespace prehend::control
