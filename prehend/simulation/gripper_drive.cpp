#include "prehend/simulation/gripper_drive.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "prehend/simulation/trapezoid.h"
#include "prehend/simulation/world.h"

namespace prehend::simulation {
namespace {

constexpr double kStandingSpeed = 2e-4;      // m/s, below it the jaw counts as standing
constexpr double kPositionTolerance = 2e-4;  // m
constexpr double kStopStiffness = 1e6;       // N/m, of the mechanical end stops

}  // namespace

GripperDrive::GripperDrive(const robot::GripperModel& model, double opening)
    : model_(model), mode_(GripperMode::kStop), reference_(opening), opening_(opening) {
  friction_law_.bristle_stiffness = 1e6;
  friction_law_.bristle_damping = 2 * std::sqrt(1e6 * effective_mass());
  friction_law_.viscous_friction = 0;
  friction_law_.static_friction = 1;
  friction_law_.dynamic_friction = 1;
  damping_ = 2 * std::sqrt(stiffness_ * effective_mass());
  command(GripperMode::kStop, 0, 0, 0);
}

void GripperDrive::command(GripperMode mode, double value, double current_limit, double speed) {
  if (!std::isfinite(value) || !std::isfinite(current_limit) || !std::isfinite(speed)) {
    throw std::invalid_argument("gripper command must be finite");
  }
  if (current_limit < 0 || speed < 0) {
    throw std::invalid_argument("gripper current limit and speed must not be negative");
  }
  if (mode == GripperMode::kPosition && !(value >= 0 && value <= model_.max_opening)) {
    throw std::invalid_argument("gripper opening must be from 0 to " +
                                std::to_string(model_.max_opening) + " m");
  }
  // Bumpless: the reference starts where it asks for the force that is there.
  if (mode != mode_) {
    reference_ = opening_ + drive_force_ / stiffness_;
    reference_speed_ = velocity_;
    blocked_time_ = 0;
  }
  double current = current_limit > 0 ? current_limit : model_.nominal_current;
  speed_limit_ = model_.max_speed;
  target_ = value;
  switch (mode) {
    case GripperMode::kPosition:
      if (speed > 0) speed_limit_ = std::min(speed, model_.max_speed);
      break;
    case GripperMode::kVelocity:
      target_ = std::clamp(value, -model_.max_speed, model_.max_speed);
      break;
    case GripperMode::kCurrent:
      current = std::abs(value);
      target_ = value == 0 ? 0.0 : std::copysign(model_.max_speed, value);
      break;
    case GripperMode::kStop:
      target_ = 0;
      break;
  }
  mode_ = mode;
  force_limit_ = model_.force_per_current * std::min(current, model_.max_current);
}

void GripperDrive::begin_step(double h) {
  const double a = model_.max_acceleration;
  // Anti-windup: a jaw that lags behind by more than the limit's deflection is blocked.
  const double lead = 1.2 * force_limit_ / stiffness_;
  const double cut = std::clamp(reference_, opening_ - lead, opening_ + lead);
  if (cut != reference_) {
    reference_ = cut;
    reference_speed_ = std::clamp(reference_speed_, velocity_ - a * h, velocity_ + a * h);
  }
  if (mode_ == GripperMode::kPosition) {
    reference_speed_ =
        next_trapezoid_speed(target_ - reference_, reference_speed_, speed_limit_, a, h);
  } else if (target_ == 0) {
    reference_speed_ -= std::clamp(reference_speed_, -a * h, a * h);
  } else {
    const double end = target_ > 0 ? model_.max_opening : 0.0;
    reference_speed_ =
        next_trapezoid_speed(end - reference_, reference_speed_, std::abs(target_), a, h);
  }
  reference_ += h * reference_speed_;
}

double GripperDrive::servo_force(double h, double velocity) const {
  return stiffness_ * (reference_ - opening_ - h * velocity) +
         damping_ * (reference_speed_ - velocity);
}

contact::LinearisedContact GripperDrive::friction(double h, double velocity) const {
  contact::LinearisedContact dry;
  const double trial = bristle_ + h * velocity;
  contact::linearise_friction(friction_law_, h, model_.friction_force, std::abs(velocity),
                              std::abs(trial), trial * velocity > 0, dry);
  return dry;
}

int GripperDrive::next_saturation(double h, double velocity, int assumed) const {
  const double servo = servo_force(h, velocity);
  const int next = servo > force_limit_ ? 1 : servo < -force_limit_ ? -1 : 0;
  return next * assumed < 0 ? 0 : next;
}

GripperDrive::Force GripperDrive::linearised(double h, double velocity_guess,
                                             int saturation) const {
  Force force;
  if (saturation != 0) {
    force.constant = saturation * force_limit_;
  } else {
    force.constant = servo_force(h, 0);
    force.slope = h * stiffness_ + damping_;
  }
  const contact::LinearisedContact dry = friction(h, velocity_guess);
  force.constant -= dry.bristle_gain * bristle_;
  force.slope += dry.tangential_damping;
  const double end = opening_ + h * velocity_guess;
  const double beyond = end < 0                    ? opening_
                        : end > model_.max_opening ? opening_ - model_.max_opening
                                                   : 0.0;
  if (end < 0 || end > model_.max_opening) {
    force.constant -= kStopStiffness * beyond;
    force.slope += h * kStopStiffness + damping_;
  }
  return force;
}

void GripperDrive::end_step(double h, double velocity) {
  drive_force_ = std::clamp(servo_force(h, velocity), -force_limit_, force_limit_);
  saturation_ = next_saturation(h, velocity, 0);
  const contact::LinearisedContact dry = friction(h, velocity);
  bristle_ = std::clamp((bristle_ + h * velocity) / dry.decay,
                        -model_.friction_force / friction_law_.bristle_stiffness,
                        model_.friction_force / friction_law_.bristle_stiffness);
  velocity_ = velocity;
  opening_ += h * velocity;
  const bool stuck = wants_to_move() && std::abs(velocity_) < kStandingSpeed;
  blocked_time_ = stuck ? blocked_time_ + h : 0.0;
}

bool GripperDrive::wants_to_move() const {
  if (mode_ == GripperMode::kPosition) return std::abs(target_ - opening_) > kPositionTolerance;
  if (target_ == 0) return false;
  const double end = target_ > 0 ? model_.max_opening : 0.0;
  return std::abs(end - opening_) > kPositionTolerance;
}

bool GripperDrive::moving() const { return std::abs(velocity_) > kStandingSpeed; }

}  // namespace prehend::simulation
