#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "prehend/contact/slide.h"
#include "prehend/robot/command_modes.h"

namespace prehend::simulation {

/// What a plug-in was compiled with; another one is not loaded.
inline constexpr int kActuatorInterface = 1;

/// The joint of a hand that an actuator moves, as its motor sees it. Units here and below are those
/// of a joint that turns; of one that slides m for rad, N for N m, kg for kg m^2.
struct ActuatedJoint {
  std::string name;
  bool slides = false;
  double lower = 0, upper = 0;  // rad
  double max_velocity = 0;      // rad/s, > 0
  double max_effort = 0;        // N m, > 0
  /// Of the position loop that the hand's controller closes [N m/rad, N m s/rad], > 0.
  double stiffness = 0, damping = 0;
};

/// What the hand's controller asks for over a step.
struct ActuatorRequest {
  /// kPosition, kEffort or kVoltage: for stops and speeds the controller moves a position.
  robot::JointMode mode = robot::JointMode::kPosition;
  double value = 0;        // rad at the step's end, N m or V
  double speed = 0;        // rad/s, that of `value` in kPosition
  double most_effort = 0;  // N m, > 0
};

struct JointMotion {
  double position = 0;  // rad
  double velocity = 0;  // rad/s
};

/// What an actuator adds to its joint.
struct ActuatorMechanics {
  double inertia = 0;   // kg m^2, >= 0, of what turns with the joint
  double friction = 0;  // N m, >= 0, Coulomb
  double damping = 0;   // N m s/rad, >= 0
  /// N m/rad, >= 0, with which it holds a position; 0: with that of the hand's loop.
  double stiffness = 0;
};

/// A value that the robot's file gives an actuator.
struct ActuatorParameter {
  std::string name, unit, about;
  std::optional<double> default_value;  // none: it must be given
};

/// What moves a joint: a motor with its gear, a valve with its cylinder, a spring behind a motor.
/// The object is what does not change; what does is `state`, numbers that belong to the hand's
/// state, so that every state of a world can be saved, copied and gone back to. A step is: drive()
/// before, observe() after it. No call may keep anything else, throw (but configure()) or depend on
/// time.
class Actuator {
 public:
  virtual ~Actuator() = default;
  virtual std::string name() const = 0;   // in files, of a-z, 0-9 and _
  virtual std::string about() const = 0;  // half a line
  virtual std::vector<ActuatorParameter> parameters() const = 0;

  /// Once, before all that follows; `values` in the order of parameters(), finite.
  /// @throws std::invalid_argument "`parameter` must be ..." naming the parameter.
  virtual void configure(const ActuatedJoint& joint, const std::vector<double>& values) = 0;
  /// Whether it does what is asked in this mode: kEffort or kVoltage; kPosition it must.
  virtual bool takes(robot::JointMode mode) const = 0;
  virtual ActuatorMechanics mechanics() const = 0;

  /// At rest with the joint at `position` [rad]. Its size never changes.
  virtual std::vector<double> initial_state(double position) const = 0;
  /// The effort on the joint over the coming step of `h` [s], which begins with `start`: affine in
  /// the velocity at its end, and bounded (contact/slide.h; `more_friction` does not count).
  virtual contact::SlideCommand drive(const ActuatorRequest& request, double h,
                                      const JointMotion& start, std::span<double> state) const = 0;
  /// After the step: the motion at its end, and the effort [N m] that was given in it.
  virtual void observe(double h, const JointMotion& end, double effort,
                       std::span<double> state) const = 0;
  /// A, of the motor; not a number where there is none.
  virtual double current(std::span<const double> state) const = 0;
};

}  // namespace prehend::simulation
