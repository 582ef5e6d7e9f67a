#include "prehend/simulation/gripper_axis.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/simulation/trapezoid.h"
#include "prehend/simulation/world.h"

namespace prehend::simulation {
namespace {

constexpr double kStandingSpeed = 2e-4;      // m/s, below it the jaw counts as standing
constexpr double kPositionTolerance = 2e-4;  // m
constexpr double kNoSpeed = 1e-9;            // m/s, as a limit, where 0 means another

}  // namespace

GripperAxis::GripperAxis(const robot::GripperModel& gripper, const SpindleDriveModel& drive)
    : gripper_(gripper), drive_(drive_of(gripper, drive)), mode_(GripperMode::kStop) {
  command(GripperMode::kStop, 0, 0, 0);
}

void GripperAxis::command(GripperMode mode, double value, double current_limit, double speed) {
  if (!std::isfinite(value) || !std::isfinite(current_limit) || !std::isfinite(speed)) {
    throw std::invalid_argument("gripper command must be finite");
  }
  if (current_limit < 0 || speed < 0) {
    throw std::invalid_argument("gripper current limit and speed must not be negative");
  }
  if (mode == GripperMode::kPosition && !(value >= 0 && value <= gripper_.max_opening)) {
    throw std::invalid_argument("gripper opening must be from 0 to " +
                                std::to_string(gripper_.max_opening) + " m");
  }
  double current = current_limit > 0 ? current_limit : gripper_.nominal_current;
  ControlMode control = ControlMode::kVelocity;
  target_ = value;
  switch (mode) {
    case GripperMode::kPosition:
      control = ControlMode::kPosition;
      break;
    case GripperMode::kVelocity:
      target_ = std::clamp(value, -gripper_.max_speed, gripper_.max_speed);
      break;
    case GripperMode::kCurrent:
      // Nothing asked for: the motor is without current, not braked.
      if (value == 0) control = ControlMode::kCurrent;
      current = std::abs(value);
      target_ = value == 0 ? 0.0 : std::copysign(gripper_.max_speed, value);
      break;
    case GripperMode::kVoltage:
      control = ControlMode::kVoltage;
      target_ = std::clamp(value, -drive_.model().supply, drive_.model().supply);
      break;
    case GripperMode::kStop:
      target_ = 0;
      break;
  }
  if (mode != mode_) blocked_time_ = 0;
  mode_ = mode;
  drive_.set_limits(std::min(current, gripper_.max_current),
                    mode == GripperMode::kPosition ? speed : 0.0);
  drive_.command(control, -target_);
}

double GripperAxis::to_end(double position) const {
  return target_ < 0 ? -position : gripper_.max_opening + position;
}

double GripperAxis::steady_time(double position) const {
  const double of_drive = drive_.steady_time(position);
  if (mode_ == GripperMode::kVoltage) return blocked() ? of_drive : 0.0;
  if (mode_ == GripperMode::kPosition || target_ == 0) return of_drive;
  const double left = to_end(position), speed = std::abs(target_);
  if (left < kPositionTolerance && !moving_) return of_drive;  // stands at the end of its stroke
  const double to_brake = left / speed - 0.5 * speed / gripper_.max_acceleration;
  return std::max(0.0, std::min(of_drive, to_brake));
}

contact::SlideCommand GripperAxis::begin_step(double h, double position, double velocity) {
  if (mode_ != GripperMode::kPosition && target_ != 0) {
    // No faster than what stops at the end of the stroke.
    const double left = std::max(0.0, to_end(position));
    const double most = stopping_speed(left, gripper_.max_acceleration, h);
    if (mode_ == GripperMode::kVoltage) {
      drive_.set_speed_limit(std::clamp(most, kNoSpeed, gripper_.max_speed));
    } else {
      drive_.command(ControlMode::kVelocity,
                     -std::copysign(std::min(std::abs(target_), most), target_));
    }
  }
  return drive_.drive(h, position, velocity);
}

void GripperAxis::end_step(double h, double position, double velocity) {
  drive_.observe(h, position, velocity);
  moving_ = std::abs(velocity) > kStandingSpeed;
  const double left = mode_ == GripperMode::kPosition ? std::abs(target_ + position)
                      : target_ == 0                  ? 0.0
                                                      : std::abs(to_end(position));
  blocked_time_ = left > kPositionTolerance && !moving_ ? blocked_time_ + h : 0.0;
}

}  // namespace prehend::simulation
