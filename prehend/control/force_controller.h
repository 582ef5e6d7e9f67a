#pragma once

namespace prehend::control {

struct ForceControllerOptions {
  double force_per_current = 30;   // N of each finger per A, > 0
  double least_current = 0.05;     // A, >= 0
  double largest_current = 2.0;    // A, > least_current
  double proportional_gain = 0.4;  // of the loop (dimensionless: N commanded per N of error), >= 0
  double integral_gain = 4.0;      // 1/s, > 0
  double force_rate = 60;          // N/s, > 0, by which the reference rises to the target
  double tolerance = 0.05;         // of the target, > 0: closer is settled and not integrated, so
                                   // that the drive's dry friction causes no hunting

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// Proportional-integral control of the grip force through the motor's current limit:
///   r(t)  rises to the target at force_rate,        e = r - f
///   u = (r + Kp e + I) / force_per_current,        dI/dt = Ki e
/// u is limited to [least_current, largest_current]; while it is limited, I is held unless the
/// error leads out of the limit (conditional integration), so it does not wind up. With the plant
/// f = force_per_current u - b (b a constant, e.g. dry friction) the error decays as
/// exp(-Ki t / (1 + Kp)) and b costs no steady error.
class ForceController {
 public:
  explicit ForceController(const ForceControllerOptions& options);

  /// Starts towards `target` [N, > 0] from the force felt now [N].
  void start(double target, double felt);

  /// Goes on towards another `target` [N, > 0] from where it is: what it has found of the plant it
  /// keeps.
  void aim(double target);

  /// One step of `dt` [s, > 0] with the force felt [N]; returns the current limit [A]. A value that
  /// is not finite for `felt` leaves the command as it was.
  double update(double felt, double dt);

  double target() const { return target_; }        // N
  double reference() const { return reference_; }  // N
  double current() const { return current_; }      // A, last command
  /// True once the reference is the target and the felt force is within the tolerance of it.
  bool settled() const { return settled_; }

 private:
  ForceControllerOptions options_;
  double target_ = 0;
  double reference_ = 0;
  double integral_ = 0;  // N
  double current_ = 0;
  bool settled_ = false;
};

}  // namespace prehend::control
