#include "prehend/simulation/dc_motor.h"

#include <algorithm>
#include <cmath>

#include "prehend/contact/require.h"

namespace prehend::simulation {
namespace {

constexpr double kCopper = 0.00393;  // 1/K, temperature coefficient of copper's resistance
// K below the hottest where the limit begins to fall; without, it would toggle.
constexpr double kFoldBack = 10;
constexpr double kStiffness = 10;  // of a bound of speed, in masses over a step

// What the servo's part asks for at the step's end, with the present velocity.
double servo_force(const contact::SlideCommand& drive, double h, double position, double velocity) {
  return drive.stiffness * (drive.reference + h * drive.speed - position) +
         drive.damping * (drive.speed - velocity);
}

}  // namespace

void validate(const DcMotorModel& model, const std::string& owner) {
  using contact::require;
  using contact::require_positive;
  require_positive(model.supply, owner + "supply");
  require_positive(model.resistance, owner + "resistance");
  require_positive(model.rotor_inertia, owner + "rotor_inertia");
  require_positive(model.torque_constant, owner + "torque_constant");
  require_positive(model.nominal_current, owner + "nominal_current");
  require(std::isfinite(model.peak_current) && model.peak_current >= model.nominal_current,
          owner + "peak_current", "finite and at least nominal_current");
  require(std::isfinite(model.ambient), owner + "ambient", "finite");
  require_positive(model.thermal_resistance, owner + "thermal_resistance");
  require_positive(model.thermal_capacity, owner + "thermal_capacity");
  require(model.hottest > model.ambient, owner + "hottest", "above ambient");
}

double winding_resistance(const DcMotorModel& model, double temperature) {
  return model.resistance * (1 + kCopper * (temperature - 25));
}

double bearable_current(const DcMotorModel& model, double temperature) {
  const double left = std::clamp((model.hottest - temperature) / kFoldBack, 0.0, 1.0);
  return model.nominal_current + left * (model.peak_current - model.nominal_current);
}

double next_temperature(const DcMotorModel& model, double temperature, double current, double h) {
  const double heat = winding_resistance(model, temperature) * current * current;
  const double time_constant = model.thermal_resistance * model.thermal_capacity;
  const double final = model.ambient + model.thermal_resistance * heat;
  return final + (temperature - final) * std::exp(-h / time_constant);
}

// Judged at the present velocity.
contact::SlideCommand DcMotorAtLoad::within_supply(const contact::SlideCommand& asked,
                                                   double present, double velocity) const {
  const double K = force_per_current, R = resistance;
  const double driven = (supply - emf * velocity) / R;
  const double braked = (-supply - emf * velocity) / R;
  if (present <= driven && present >= braked) return asked;
  contact::SlideCommand drive;
  drive.force = std::copysign(K * supply / R, present > driven ? 1.0 : -1.0);
  drive.damping = K * emf / R;
  return drive;
}

contact::SlideCommand DcMotorAtLoad::at_current(double current, double velocity) const {
  const double present = std::clamp(current, -limit, limit);
  contact::SlideCommand drive;
  drive.force = force_per_current * present;
  return within_supply(drive, present, velocity);
}

contact::SlideCommand DcMotorAtLoad::at_voltage(double voltage, double velocity) const {
  const double K = force_per_current, R = resistance;
  voltage = std::clamp(voltage, -supply, supply);
  double present = (voltage - emf * velocity) / R;
  contact::SlideCommand drive;
  drive.force = K * voltage / R;
  drive.damping = K * emf / R;
  if (std::abs(present) > limit) {
    present = std::copysign(limit, present);
    drive.force = K * present;
    drive.damping = 0;
  }
  return within_supply(drive, present, velocity);
}

contact::SlideCommand DcMotorAtLoad::at_servo(const contact::SlideCommand& servo, double h,
                                              double position, double velocity) const {
  contact::SlideCommand drive = servo;
  drive.limit = force_per_current * limit;
  const double asked = servo_force(drive, h, position, velocity);
  return within_supply(drive, std::clamp(asked / force_per_current, -limit, limit), velocity);
}

contact::SlideCommand bounded_in_speed(const contact::SlideCommand& drive, double sense,
                                       double most, double brake, double mass, double h,
                                       double position, double velocity) {
  const double servo = servo_force(drive, h, position, velocity);
  const double present = drive.force + std::clamp(servo, -drive.limit, drive.limit);
  const double falling = std::abs(servo) < drive.limit ? h * drive.stiffness + drive.damping : 0.0;
  const double next = velocity + h * present / (mass + h * falling);
  // The drive's part of the law below is between its present force and the brake's.
  const double driving = sense * present;
  if (sense * next <= most || driving < -brake) return drive;
  const double middle = 0.5 * (driving - brake), gain = kStiffness * mass / h;
  contact::SlideCommand bounded;
  bounded.force = sense * middle;
  bounded.damping = gain;
  bounded.speed = sense * (most - middle / gain);
  bounded.limit = 0.5 * (driving + brake);
  bounded.more_friction = drive.more_friction;
  return bounded;
}

}  // namespace prehend::simulation
