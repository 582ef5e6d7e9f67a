#pragma once

#include "prehend/robot/command_modes.h"
#include "prehend/robot/gripper_model.h"
#include "prehend/simulation/spindle_drive.h"

namespace prehend::simulation {

/// The gripper's controller and drive on the slide that both jaws share. The slide's coordinate is
/// minus the opening, so that positive closes, as an Actuator has it:
///   m dv/dt = F - friction - (Fn_left + Fn_right) / 2
/// kCurrent is the servo with the maximum speed as reference and |current| as limit, so that a
/// blocked jaw presses with force_per_current |i| less friction; kVoltage drives the motor as it
/// is, within supply, current and maximum speed; kStop brakes and holds. Before the ends of the
/// stroke it brakes by itself. Its state is its value: copy to save.
class GripperAxis {
 public:
  GripperAxis(const robot::GripperModel& gripper, const SpindleDriveModel& drive);

  /// See World::set_gripper_command.
  void command(robot::GripperMode mode, double value, double current_limit, double speed);

  /// The drive over the coming step of `h` [s] from the slide's position [m] and velocity [m/s].
  contact::SlideCommand begin_step(double h, double position, double velocity);
  /// What the solved step did.
  void end_step(double h, double position, double velocity);
  /// See SpindleDrive::observe_load.
  void observe_load(double load) { drive_.observe_load(load); }

  /// For how long [s] it goes on as it does, see SpindleDrive::steady_time.
  double steady_time(double position) const;

  contact::SlideModel slide() const { return drive_.slide(); }
  double current() const { return -drive_.current(); }  // A, negative closes
  double temperature() const { return drive_.temperature(); }
  bool moving() const { return moving_; }
  bool blocked() const { return blocked_time_ > kBlockedTime; }

  template <class Archive>
  void archive(Archive& archive) {
    drive_.archive(archive);
    archive(mode_, target_, moving_, blocked_time_);
  }

 private:
  static constexpr double kBlockedTime = 0.05;  // s
  /// Distance to the end towards which velocity mode goes [m].
  double to_end(double position) const;

  robot::GripperModel gripper_;
  SpindleDrive drive_;
  robot::GripperMode mode_;
  double target_ = 0;  // of the opening: m or m/s; kVoltage: V
  bool moving_ = false;
  double blocked_time_ = 0;  // s
};

}  // namespace prehend::simulation
