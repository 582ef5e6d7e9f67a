#include "prehend/simulation/actuator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "prehend/contact/require.h"
#include "prehend/simulation/trapezoid.h"

namespace prehend::simulation {
namespace {

constexpr double kCopper = 0.00393;  // 1/K, temperature coefficient of copper's resistance
// K below the hottest where the limit begins to fall; without, it would toggle.
constexpr double kFoldBack = 10;

}  // namespace

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
  require_positive(model.supply, "SpindleDriveModel::supply");
  require_positive(model.resistance, "SpindleDriveModel::resistance");
  require_positive(model.rotor_inertia, "SpindleDriveModel::rotor_inertia");
  require_positive(model.torque_constant, "SpindleDriveModel::torque_constant");
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
  require_positive(model.nominal_current, "SpindleDriveModel::nominal_current");
  require(std::isfinite(model.peak_current) && model.peak_current >= model.nominal_current,
          "SpindleDriveModel::peak_current", "finite and at least nominal_current");
  require_positive(model.max_speed, "SpindleDriveModel::max_speed");
  require_positive(model.max_acceleration, "SpindleDriveModel::max_acceleration");
  require(std::isfinite(model.ambient), "SpindleDriveModel::ambient", "finite");
  require_positive(model.thermal_resistance, "SpindleDriveModel::thermal_resistance");
  require_positive(model.thermal_capacity, "SpindleDriveModel::thermal_capacity");
  require(model.hottest > model.ambient, "SpindleDriveModel::hottest", "above ambient");
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
  contact::require_not_negative(speed, "an actuator's speed limit");
  most_current_ = current;
  most_speed_ = speed;
}

double SpindleDrive::resistance() const {
  return model_.resistance * (1 + kCopper * (temperature_ - 25));
}

double SpindleDrive::current_limit() const {
  const double left = std::clamp((model_.hottest - temperature_) / kFoldBack, 0.0, 1.0);
  const double able =
      model_.nominal_current + left * (model_.peak_current - model_.nominal_current);
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
  // Anti-windup: a slide that lags by more than the limit's deflection is blocked.
  const double most_lead = 1.2 * limit / model_.servo_stiffness;
  const double cut = std::clamp(reference_, position - most_lead, position + most_lead);
  if (cut != reference_) {
    reference_ = cut;
    speed_reference_ = std::clamp(speed_reference_, velocity - a * h, velocity + a * h);
  }
  const double speed = most_speed_ > 0 ? std::min(most_speed_, model_.max_speed) : model_.max_speed;
  if (mode_ == ControlMode::kPosition) {
    speed_reference_ = next_trapezoid_speed(target_ - reference_, speed_reference_, speed, a, h);
  } else {
    const double wanted = std::clamp(target_, -speed, speed);
    speed_reference_ += std::clamp(wanted - speed_reference_, -a * h, a * h);
  }
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
  const double K = model_.force_per_current(), emf = model_.torque_constant * model_.ratio();
  const double R = resistance(), limit = current_limit();
  last_ = {};
  double present = 0;  // A, asked for at the present velocity
  if (mode_ == ControlMode::kCurrent) {
    present = std::clamp(target_, -limit, limit);
    last_.force = K * present;
  } else if (mode_ == ControlMode::kVoltage) {
    const double voltage = std::clamp(target_, -model_.supply, model_.supply);
    present = (voltage - emf * velocity) / R;
    last_.force = K * voltage / R;
    last_.damping = K * emf / R;
    if (std::abs(present) > limit) {
      present = std::copysign(limit, present);
      last_.force = K * present;
      last_.damping = 0;
    }
  } else {
    const double before = begins_ ? velocity : speed_reference_;
    lead(h, position, velocity, K * limit);
    // None after a jump by the anti-windup.
    const double acceleration = (speed_reference_ - before) / h;
    const double most = model_.max_acceleration * (1 + 1e-9);
    last_.stiffness = model_.servo_stiffness;
    last_.reference = reference_;
    if (std::abs(acceleration) <= most) {
      last_.reference += model_.reflected_mass() * acceleration / model_.servo_stiffness;
    }
    last_.damping = model_.velocity_gain;
    last_.speed = speed_reference_;
    last_.limit = K * limit;
    const double servo = last_.stiffness * (last_.reference + h * last_.speed - position) +
                         last_.damping * (last_.speed - velocity);
    present = std::clamp(servo / K, -limit, limit);
  }
  // What supply and back-EMF allow, judged at the present velocity.
  const double driven = (model_.supply - emf * velocity) / R;
  const double braked = (-model_.supply - emf * velocity) / R;
  if (present > driven || present < braked) {
    last_ = {};
    last_.force = std::copysign(K * model_.supply / R, present > driven ? 1.0 : -1.0);
    last_.damping = K * emf / R;
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
  const double heat = resistance() * current_ * current_;
  const double time_constant = model_.thermal_resistance * model_.thermal_capacity;
  const double final = model_.ambient + model_.thermal_resistance * heat;
  temperature_ = final + (temperature_ - final) * std::exp(-h / time_constant);
}

}  // namespace prehend::simulation
