#pragma once

#include <optional>

#include "prehend/contact/slide.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/simulation/dc_motor.h"
#include "prehend/simulation/power_screw.h"

namespace prehend::simulation {

enum class ControlMode { kPosition, kVelocity, kVoltage, kCurrent };

/// A DC motor with gear and spindle. Everything but the motor is in the coordinate of the slide.
struct SpindleDriveModel : DcMotorModel {
  double gear_ratio = 4;
  double spindle_lead = 0.018;  // m of the opening for each turn of the spindle
  double efficiency = 0.7;      // of gear and spindle, from motor to jaws; estimate
  double jaw_mass = 0.1;        // kg, of each of two jaws; estimate

  /// Friction of the spindle's thread, which grows with the force that it transmits; then
  /// `efficiency` is the gear's alone and the thread's lead is half of `spindle_lead`, since two
  /// threads move a jaw each. Without: friction as below, whatever the load.
  struct Thread {
    double mean_diameter = 0.010;  // m
    double friction = 0.1;         // Coulomb, of the flanks
    double flank_angle = 0;        // rad, see PowerScrew
  };
  std::optional<Thread> thread;
  PowerScrew screw() const;  // @pre thread

  // Friction of gear, spindle and guides, at the jaws.
  double static_friction = 10;       // N, stiction
  double coulomb_friction = 8;       // N
  double viscous_friction = 20;      // N s/m
  double stribeck_velocity = 0.002;  // m/s

  double max_speed = 0.083;        // m/s, of the opening
  double max_acceleration = 0.32;  // m/s^2

  // The controller's servo, at the jaws: integral and proportional part of its velocity loop.
  double servo_stiffness = 1e6;  // N/m
  double velocity_gain = 4000;   // N s/m; critical damping of 4 kg

  double ratio() const;              // rad of the rotor for each metre of the opening
  double force_per_current() const;  // N of each jaw for each A, before friction
  double reflected_mass() const;     // kg of the coordinate: rotor and jaws
  /// Least force on the jaws that turns the motor by itself [N]; infinity when the transmission
  /// locks itself (efficiency of 1/2 or less, or a thread whose friction exceeds the tangent of its
  /// lead angle).
  double back_drive_force() const;
};

/// The Schunk PG70's: speed, acceleration, supply and currents as in its driver and data sheet, the
/// rest estimated so that 30 N/A and 8 N of friction come out, as in config/robots/pg70_dsa.yaml.
SpindleDriveModel pg70_drive();

/// @throws std::invalid_argument naming the field.
void validate(const SpindleDriveModel& model);

/// `rest` with what a gripper's data sheet says: speed, acceleration, currents, force for each
/// ampere (by the efficiency), friction (stiction in the ratio that `rest` has) and jaws.
/// @throws std::invalid_argument when `rest`'s motor and gear cannot give that force.
SpindleDriveModel drive_of(const robot::GripperModel& gripper, const SpindleDriveModel& rest);

/// What drives one prismatic coordinate q of a grasp (its slide), e.g. the closing of both jaws.
/// Positive closes. A servo follows a trapezoidal reference of position and speed, with current and
/// voltage limits, back-EMF, heat (dc_motor.h).
///   F = K i = Ki (x_ref - q) + Kv (v_ref - dq/dt) + m a_ref,   |i| <= limit
/// kPosition and kVelocity use it; the reference never leads by more than the limit needs, so that
/// reversal is immediate and a blocked drive presses with the limit. kVoltage and kCurrent go to
/// the motor as they are. A step is: command() when there is a new one, drive() before the step,
/// observe() after it. Its state is its value: copy to save.
class SpindleDrive {
 public:
  explicit SpindleDrive(const SpindleDriveModel& model);
  /// Lowers the limits of current [A] and of the servo's speed [m/s]; 0 means the model's. A speed
  /// other than 0 bounds that of kVoltage, too (bounded_in_speed).
  /// @throws std::invalid_argument when not finite or negative.
  void set_limits(double current, double speed);
  void set_speed_limit(double speed);
  /// `target`: m, m/s, V or A by mode. @throws std::invalid_argument when not finite.
  void command(ControlMode mode, double target);
  /// The force on the slide over the coming step of `h` [s], affine in its velocity at the end,
  /// from position [m] and velocity [m/s] at the start.
  contact::SlideCommand drive(double h, double position, double velocity);
  /// What the solved velocity [m/s] did to current, temperature and integrators.
  void observe(double h, double position, double velocity);
  /// Mass, friction and stiction of the slide with this drive.
  contact::SlideModel slide() const;
  /// The force that opposes closing [N] from outside, at each jaw, in the last step; counts only
  /// with a thread, whose friction in the next step is that of this load: against it
  /// friction_against_load(), along with it friction_along_load() times the load. Half the
  /// difference of the two is a force against the load, half the sum is friction.
  void observe_load(double load) { load_ = load; }
  double current() const { return current_; }          // A, positive closes
  double temperature() const { return temperature_; }  // degrees Celsius
  double current_limit() const;                        // A, now
  /// For how long [s] the servo's speed stays as it is, unless something gets in its way, with the
  /// slide at `position` [m]: 0 while it speeds up or brakes, infinity when blocked or not asked.
  double steady_time(double position) const;
  const SpindleDriveModel& model() const { return model_; }

  /// All that changes, for saving: see StateWriter.
  template <class Archive>
  void archive(Archive& archive) {
    archive(mode_, target_, most_current_, most_speed_, begins_, reference_, speed_reference_,
            current_, temperature_);
    if (model_.thread) archive(load_);
  }

 private:
  contact::SlideCommand motor(double h, double position, double velocity);
  void lead(double h, double position, double velocity, double limit);

  SpindleDriveModel model_;
  ControlMode mode_ = ControlMode::kCurrent;
  double target_ = 0;
  double most_current_ = 0, most_speed_ = 0;  // A, m/s; 0: the model's
  bool begins_ = true;                        // the reference starts where the slide is
  double reference_ = 0;                      // m
  double speed_reference_ = 0;                // m/s
  double current_ = 0;                        // A
  double temperature_;                        // degrees Celsius
  double load_ = 0;                           // N, see observe_load
  contact::SlideCommand last_;
};

}  // namespace prehend::simulation
