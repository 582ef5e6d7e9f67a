#include "prehend/simulation/actuator.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "prehend/contact/require.h"

namespace prehend::simulation {
namespace {

constexpr double kCopper = 0.00393;  // 1/K, temperature coefficient of copper's resistance

}  // namespace

double SpindleDriveModel::ratio() const { return 2 * std::numbers::pi * gear_ratio / spindle_lead; }

double SpindleDriveModel::force_per_current() const {
  return torque_constant * ratio() * efficiency;
}

// Each jaw moves by half the opening: 1/2 m_jaw (dq/2)^2 twice.
double SpindleDriveModel::reflected_mass() const {
  return 0.5 * jaw_mass + rotor_inertia * ratio() * ratio();
}

double SpindleDriveModel::back_drive_force() const {
  if (efficiency <= 0.5) return std::numeric_limits<double>::infinity();
  // Of a force from the jaws the share 2 - 1/efficiency reaches the rotor.
  return static_friction / (2 - 1 / efficiency);
}

// 0.03 N m/A * 2 pi 4 / 18 mm * 0.716 = 30 N/A; at 24 V and no load 0.57 m/s, so that the limit of
// 83 mm/s is the controller's, not the motor's.
SpindleDriveModel pg70_drive() {
  SpindleDriveModel model;
  model.efficiency = 30 / (model.torque_constant * model.ratio());
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
  require_positive(model.position_gain, "SpindleDriveModel::position_gain");
  require_positive(model.velocity_gain, "SpindleDriveModel::velocity_gain");
}

SpindleDrive::SpindleDrive(const SpindleDriveModel& model)
    : model_(model), temperature_(model.ambient) {
  validate(model);
}

void SpindleDrive::command(ControlMode mode, double target) {
  if (!std::isfinite(target)) throw std::invalid_argument("an actuator's target must be finite");
  mode_ = mode;
  target_ = target;
}

double SpindleDrive::resistance() const {
  return model_.resistance * (1 + kCopper * (temperature_ - 25));
}

double SpindleDrive::current_limit() const {
  return temperature_ < model_.hottest ? model_.peak_current : model_.nominal_current;
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

// Current i = a - b v; force K i. Voltage (supply and back-EMF) and current limits cut it.
contact::SlideCommand SpindleDrive::drive(double h, double position, double velocity) {
  const double K = model_.force_per_current(), emf = model_.torque_constant * model_.ratio();
  const double R = resistance();
  double offset = 0, slope = 0;  // A, A s/m
  switch (mode_) {
    case ControlMode::kCurrent:
      offset = target_;
      break;
    case ControlMode::kVoltage: {
      const double voltage = std::clamp(target_, -model_.supply, model_.supply);
      offset = voltage / R;
      slope = emf / R;
      break;
    }
    case ControlMode::kPosition:
    case ControlMode::kVelocity: {
      double wanted = target_;
      if (mode_ == ControlMode::kPosition) {
        const double distance = target_ - position;
        // No faster than it can brake, and gently at the end.
        const double brake = std::sqrt(2 * model_.max_acceleration * std::abs(distance));
        wanted =
            std::copysign(std::min(brake, model_.position_gain * std::abs(distance)), distance);
      }
      wanted = std::clamp(wanted, -model_.max_speed, model_.max_speed);
      const double change = h * model_.max_acceleration;
      speed_reference_ += std::clamp(wanted - speed_reference_, -change, change);
      offset = model_.velocity_gain * speed_reference_ / K;
      slope = model_.velocity_gain / K;
      break;
    }
  }
  // Limits, judged at the present velocity.
  const double present = offset - slope * velocity;
  const double limit = current_limit();
  const double driven = (model_.supply - emf * velocity) / R;
  const double braked = (-model_.supply - emf * velocity) / R;
  if (present > std::min(limit, driven)) {
    const bool by_voltage = driven < limit;
    offset = by_voltage ? model_.supply / R : limit;
    slope = by_voltage ? emf / R : 0;
  } else if (present < std::max(-limit, braked)) {
    const bool by_voltage = braked > -limit;
    offset = by_voltage ? -model_.supply / R : -limit;
    slope = by_voltage ? emf / R : 0;
  }
  last_ = {};
  last_.force = K * offset;
  last_.damping = K * slope;
  return last_;
}

void SpindleDrive::observe(double h, double, double velocity) {
  current_ = (last_.force - last_.damping * velocity) / model_.force_per_current();
  const double heat = resistance() * current_ * current_;
  const double time_constant = model_.thermal_resistance * model_.thermal_capacity;
  const double final = model_.ambient + model_.thermal_resistance * heat;
  temperature_ = final + (temperature_ - final) * std::exp(-h / time_constant);
  if (mode_ == ControlMode::kCurrent || mode_ == ControlMode::kVoltage) speed_reference_ = velocity;
}

}  // namespace prehend::simulation
