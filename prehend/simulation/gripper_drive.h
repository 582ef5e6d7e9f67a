#pragma once

#include "prehend/contact/texel.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::simulation {

enum class GripperMode;

/// The drive of a parallel gripper in the coordinate of its opening s: a servo that follows a
/// trapezoidal reference, its force cut at the current limit, with Coulomb friction.
///
///   m ds'/dt = Fd - Ff - (Fn_left + Fn_right) / 2,   m = jaw_mass / 2
///   Fd = clamp(Kp (s_ref - s) + Kd (v_ref - s'), +-limit),   limit = force_per_current * current
///
/// Forces are those of each finger. kCurrent is the same servo with the maximum speed as reference
/// and |current| as limit, so that a blocked jaw presses with force_per_current |i| - friction.
/// The reference never runs ahead further than the limit needs, so reversal is immediate.
/// kStop brakes with the model's acceleration and holds. Its state is its value: copy to save.
class GripperDrive {
 public:
  GripperDrive(const robot::GripperModel& model, double opening);

  /// See World::set_gripper_command.
  void command(GripperMode mode, double value, double current_limit, double speed);

  /// Advances the reference for the coming step.
  void begin_step(double h);

  /// Force along the opening as function of its velocity at the step's end: constant - slope v.
  struct Force {
    double constant = 0;  // N
    double slope = 0;     // N s/m, >= 0
  };
  /// Friction and end stops are linearised at a guess of that velocity [m/s]; `saturation` says
  /// whether the servo's force is cut: 0 no, +1 or -1 at the limit.
  Force linearised(double h, double velocity_guess, int saturation) const;

  /// The state of the servo for a solution: start with that of the last step, then solve again
  /// while this differs from what was assumed. It settles, since the servo's force falls with the
  /// velocity and the solution without cut tells on which side the cut is; hence from one limit to
  /// the other it goes by way of 0.
  int next_saturation(double h, double velocity, int assumed) const;
  int last_saturation() const { return saturation_; }

  /// Takes the solved velocity of the opening and moves.
  void end_step(double h, double velocity);

  double opening() const { return opening_; }                                 // m
  double velocity() const { return velocity_; }                               // m/s
  double effective_mass() const { return 0.5 * model_.jaw_mass; }             // kg
  double current() const { return drive_force_ / model_.force_per_current; }  // A, negative closes
  bool moving() const;
  bool blocked() const { return blocked_time_ > kBlockedTime; }

 private:
  static constexpr double kBlockedTime = 0.05;          // s
  double servo_force(double h, double velocity) const;  // N, not cut
  contact::LinearisedContact friction(double h, double velocity) const;
  bool wants_to_move() const;

  robot::GripperModel model_;
  contact::TexelLaw friction_law_;
  double stiffness_ = 1e6;  // Kp [N/m]
  double damping_ = 0;      // Kd [N s/m], critical
  GripperMode mode_;
  double target_ = 0;           // m or m/s
  double force_limit_ = 0;      // N
  double speed_limit_ = 0;      // m/s
  double reference_ = 0;        // m
  double reference_speed_ = 0;  // m/s
  double opening_ = 0;
  double velocity_ = 0;
  double bristle_ = 0;      // m, of the drive's friction
  double drive_force_ = 0;  // N
  double blocked_time_ = 0;
  int saturation_ = 0;  // in the last step
};

}  // namespace prehend::simulation
