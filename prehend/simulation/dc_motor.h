#pragma once

#include <string>

#include "prehend/contact/slide.h"

namespace prehend::simulation {

/// A DC motor, brushed or commutated by its electronics, with the heat of its winding:
/// C dT/dt = R i^2 - (T - ambient) / thermal_resistance.
struct DcMotorModel {
  double supply = 24;             // V
  double resistance = 1.5;        // Ohm of the winding at 25 degrees
  double rotor_inertia = 2.0e-6;  // kg m^2; estimate
  double torque_constant = 0.03;  // N m/A, and V s of back-EMF

  double nominal_current = 2.0;  // A
  double peak_current = 6.5;     // A

  double ambient = 25;            // degrees Celsius
  double thermal_resistance = 6;  // K/W
  double thermal_capacity = 20;   // J/K
  double hottest = 100;  // degrees; the limit falls from peak to nominal current in the 10 K before
};

/// @throws std::invalid_argument naming the field, `owner` before it ("SpindleDriveModel::").
void validate(const DcMotorModel& model, const std::string& owner);

/// Ohm at `temperature` [degrees Celsius].
double winding_resistance(const DcMotorModel& model, double temperature);
/// A that the motor bears at `temperature` [degrees Celsius].
double bearable_current(const DcMotorModel& model, double temperature);
/// The winding's temperature [degrees Celsius] after `h` [s] with `current` [A].
double next_temperature(const DcMotorModel& model, double temperature, double current, double h);

/// A DC motor at the load that its transmission moves, for one step. Units of a load that slides;
/// of one that turns N m for N and rad for m. The motor's inductance is left out: its time constant
/// is below a millisecond.
///   V = R i + emf v,   F = K i,   |V| <= supply,   |i| <= limit
struct DcMotorAtLoad {
  double force_per_current = 0;  // K, N/A, before friction
  double emf = 0;                // V s/m
  double resistance = 0;         // Ohm, now
  double supply = 0;             // V
  double limit = 0;              // A, now

  /// The force of this current [A] over the coming step that begins with `velocity` [m/s].
  contact::SlideCommand at_current(double current, double velocity) const;
  /// The same of a voltage [V], cut to the supply's.
  contact::SlideCommand at_voltage(double voltage, double velocity) const;
  /// The same of a servo that asks for `servo` (its limit is replaced by K `limit`), the load being
  /// at `position` [m]; `h` [s] is the step's length.
  contact::SlideCommand at_servo(const contact::SlideCommand& servo, double h, double position,
                                 double velocity) const;

 private:
  contact::SlideCommand within_supply(const contact::SlideCommand& asked, double present,
                                      double velocity) const;
};

/// `drive` that makes its load, of `mass` [kg] or less, no faster than `most` [m/s], >= 0, in the
/// direction `sense` (1 or -1): where it would over the coming step of `h` [s], its present force
/// or gain (most - v), whichever is less, and no more than `brake` [N] against the motion.
contact::SlideCommand bounded_in_speed(const contact::SlideCommand& drive, double sense,
                                       double most, double brake, double mass, double h,
                                       double position, double velocity);

}  // namespace prehend::simulation
