#include "prehend/simulation/spindle_drive.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "prehend/contact/require.h"
#include "prehend/simulation/trapezoid.h"

namespace prehend::simulation {

double SpindleDriveModel::ratio() const { return 2 * std::numbers::pi * gear_ratio / spindle_lead; }

double SpindleDriveModel::force_per_current() const {
  return torque_constant * ratio() * efficiency;
}

// Each jaw moves by half the opening: 1/2 m_jaw (dq/2)^2 twice.
double SpindleDriveModel::reflected_mass() const {
  return 0.5 * jaw_mass + rotor_inertia * ratio() * ratio();
}

PowerScrew SpindleDriveModel::screw() const {
  return {0.5 * spindle_lead, thread->mean_diameter, thread->friction, thread->flank_angle};
}

double SpindleDriveModel::back_drive_force() const {
  // Of a force from the jaws the share 2 - 1/efficiency reaches the rotor.
  double share = 2 - 1 / efficiency;
  if (thread) share *= 1 - screw().friction_along_load();
  if (efficiency <= 0.5 || share <= 0) return std::numeric_limits<double>::infinity();
  return static_friction / share;
}

// 0.03 N m/A * 2 pi 4 / 18 mm * 0.716 = 30 N/A; at 24 V and no load 0.57 m/s, so that the limit of
// 83 mm/s is the controller's, not the motor's.
SpindleDriveModel pg70_drive() {
  SpindleDriveModel model;
  model.efficiency = 30 / (model.torque_constant * model.ratio());
  return model;
}

SpindleDriveModel drive_of(const robot::GripperModel& gripper, const SpindleDriveModel& rest) {
  SpindleDriveModel model = rest;
  model.max_speed = gripper.max_speed;
  model.max_acceleration = gripper.max_acceleration;
  model.nominal_current = gripper.nominal_current;
  model.peak_current = gripper.max_current;
  model.jaw_mass = gripper.jaw_mass;
  const double stiction = rest.coulomb_friction > 0 ? rest.static_friction / rest.coulomb_friction
                                                    : std::numeric_limits<double>::quiet_NaN();
  model.coulomb_friction = gripper.friction_force;
  model.static_friction = std::isfinite(stiction)
                              ? stiction * gripper.friction_force
                              : std::max(gripper.friction_force, rest.static_friction);
  // The quoted force is what is left after all friction that grows with it.
  const double of_thread = model.thread ? model.screw().efficiency() : 1.0;
  model.efficiency =
      gripper.force_per_current / (model.torque_constant * model.ratio() * of_thread);
  contact::require(model.efficiency > 0 && model.efficiency <= 1, "force_per_current",
                   "at most what the drive's torque_constant, gear_ratio and spindle_lead give "
                   "without loss, or with the thread's");
  validate(model);
  return model;
}

void validate(const SpindleDriveModel& model) {
  using contact::require;
  using contact::require_not_negative;
  using contact::require_positive;
  validate(model, "SpindleDriveModel::");
  require_positive(model.gear_ratio, "SpindleDriveModel::gear_ratio");
  require_positive(model.spindle_lead, "SpindleDriveModel::spindle_lead");
  require(model.efficiency > 0 && model.efficiency <= 1, "SpindleDriveModel::efficiency",
          "above 0 and at most 1");
  if (model.thread) validate(model.screw(), "SpindleDriveModel::thread");
  require_positive(model.jaw_mass, "SpindleDriveModel::jaw_mass");
  require_not_negative(model.coulomb_friction, "SpindleDriveModel::coulomb_friction");
  require(std::isfinite(model.static_friction) && model.static_friction >= model.coulomb_friction,
          "SpindleDriveModel::static_friction", "finite and at least coulomb_friction");
  require_not_negative(model.viscous_friction, "SpindleDriveModel::viscous_friction");
  require_positive(model.stribeck_velocity, "SpindleDriveModel::stribeck_velocity");
  require_positive(model.max_speed, "SpindleDriveModel::max_speed");
  require_positive(model.max_acceleration, "SpindleDriveModel::max_acceleration");
  require_positive(model.servo_stiffness, "SpindleDriveModel::servo_stiffness");
  require_positive(model.velocity_gain, "SpindleDriveModel::velocity_gain");
}

SpindleDrive::SpindleDrive(const SpindleDriveModel& model)
    : model_(model), temperature_(model.ambient) {
  validate(model);
}

void SpindleDrive::command(ControlMode mode, double target) {
  if (!std::isfinite(target)) throw std::invalid_argument("an actuator's target must be finite");
  if (mode != mode_) begins_ = true;
  mode_ = mode;
  target_ = target;
}

void SpindleDrive::set_limits(double current, double speed) {
  contact::require_not_negative(current, "an actuator's current limit");
  set_speed_limit(speed);
  most_current_ = current;
}

void SpindleDrive::set_speed_limit(double speed) {
  contact::require_not_negative(speed, "an actuator's speed limit");
  most_speed_ = speed;
}

double SpindleDrive::current_limit() const {
  const double able = bearable_current(model_, temperature_);
  return most_current_ > 0 ? std::min(able, most_current_) : able;
}

contact::SlideModel SpindleDrive::slide() const {
  contact::SlideModel slide;
  slide.mass = model_.reflected_mass();
  slide.static_friction = model_.static_friction;
  slide.dynamic_friction = model_.coulomb_friction;
  slide.viscous_friction = model_.viscous_friction;
  slide.stribeck_velocity = model_.stribeck_velocity;
  return slide;
}

double SpindleDrive::steady_time(double position) const {
  constexpr double kForever = std::numeric_limits<double>::infinity();
  if (mode_ == ControlMode::kCurrent || mode_ == ControlMode::kVoltage) return kForever;
  if (begins_) return 0;
  const double lead = model_.servo_stiffness * std::abs(reference_ - position);
  if (lead >= model_.force_per_current() * current_limit()) return kForever;  // blocked
  const double most = most_speed_ > 0 ? std::min(most_speed_, model_.max_speed) : model_.max_speed;
  const double speed = std::abs(speed_reference_);
  if (mode_ == ControlMode::kVelocity) {
    return speed_reference_ == std::clamp(target_, -most, most) ? kForever : 0;
  }
  const double left = std::abs(target_ - reference_);
  if (left < 1e-12 && speed == 0) return kForever;
  const bool runs = speed >= most * (1 - 1e-9);
  return runs ? std::max(0.0, left / speed - 0.5 * speed / model_.max_acceleration) : 0;
}

// The servo's reference over the coming step; `limit` is that of the force [N].
void SpindleDrive::lead(double h, double position, double velocity, double limit) {
  const double a = model_.max_acceleration;
  if (begins_) {
    // Bumpless: where it asks for the force that is there.
    reference_ = position + model_.force_per_current() * current_ / model_.servo_stiffness;
    speed_reference_ = velocity;
    begins_ = false;
  }
  // Anti-windup: a slide that lags by more than the limit's deflection is blocked. The reference
  // leads by no more, nor at the step's end: so it is as fast as what is blocked, however long the
  // steps, and speeds up from there when the block gives way, or the limit.
  const double most_lead = 1.2 * limit / model_.servo_stiffness;
  reference_ = std::clamp(reference_, position - most_lead, position + most_lead);
  const double ahead = reference_ - position;
  const double speed = most_speed_ > 0 ? std::min(most_speed_, model_.max_speed) : model_.max_speed;
  if (mode_ == ControlMode::kPosition) {
    speed_reference_ = next_trapezoid_speed(target_ - reference_, speed_reference_, speed, a, h);
  } else {
    const double wanted = std::clamp(target_, -speed, speed);
    speed_reference_ += std::clamp(wanted - speed_reference_, -a * h, a * h);
  }
  speed_reference_ = std::clamp(speed_reference_, velocity - std::max(0.0, most_lead + ahead) / h,
                                velocity + std::max(0.0, most_lead - ahead) / h);
}

contact::SlideCommand SpindleDrive::drive(double h, double position, double velocity) {
  contact::SlideCommand command = motor(h, position, velocity);
  if (!model_.thread || load_ == 0) return command;
  const PowerScrew screw = model_.screw();
  const double against = screw.friction_against_load(), along = screw.friction_along_load();
  command.more_friction = 0.5 * (against + along) * std::abs(load_);
  command.force -= 0.5 * (against - along) * load_;
  return command;
}

// The motor's force on the slide, which is kept in last_ for observe().
contact::SlideCommand SpindleDrive::motor(double h, double position, double velocity) {
  const double K = model_.force_per_current();
  const DcMotorAtLoad motor{K, model_.torque_constant * model_.ratio(),
                            winding_resistance(model_, temperature_), model_.supply,
                            current_limit()};
  if (mode_ == ControlMode::kCurrent) {
    last_ = motor.at_current(target_, velocity);
  } else if (mode_ == ControlMode::kVoltage) {
    last_ = motor.at_voltage(target_, velocity);
    if (most_speed_ > 0 && target_ != 0) {
      last_ = bounded_in_speed(last_, std::copysign(1.0, target_), most_speed_, K * motor.limit,
                               model_.reflected_mass(), h, position, velocity);
    }
  } else {
    const double before = begins_ ? velocity : speed_reference_;
    lead(h, position, velocity, K * motor.limit);
    // None after a jump by the anti-windup.
    const double acceleration = (speed_reference_ - before) / h;
    const double most = model_.max_acceleration * (1 + 1e-9);
    contact::SlideCommand servo;
    servo.stiffness = model_.servo_stiffness;
    servo.reference = reference_;
    if (std::abs(acceleration) <= most) {
      servo.reference += model_.reflected_mass() * acceleration / model_.servo_stiffness;
    }
    servo.damping = model_.velocity_gain;
    servo.speed = speed_reference_;
    last_ = motor.at_servo(servo, h, position, velocity);
  }
  return last_;
}

void SpindleDrive::observe(double h, double position, double velocity) {
  const double servo = last_.stiffness * (last_.reference + h * last_.speed - position) +
                       last_.damping * (last_.speed - velocity);
  current_ =
      (last_.force + std::clamp(servo, -last_.limit, last_.limit)) / model_.force_per_current();
  if (mode_ == ControlMode::kPosition || mode_ == ControlMode::kVelocity) {
    reference_ += h * speed_reference_;
  }
  temperature_ = next_temperature(model_, temperature_, current_, h);
}

}  // namespace prehend::simulation
