#pragma once

#include "prehend/robot/command_modes.h"
#include "prehend/simulation/actuator.h"

namespace prehend::simulation {

/// Where a motor of a hand is led to by continuous commands: the reference of its position loop,
/// or an effort or voltage as it is. Within the joint's position, speed and effort, and with
/// `acceleration` [rad/s^2] at most where a reference moves. Its state is its value.
struct JointReference {
  robot::JointMode mode = robot::JointMode::kVelocity;
  double value = 0;     // rad, rad/s, N m or V
  double position = 0;  // rad, of the loop's reference
  double velocity = 0;  // rad/s

  /// The joint brakes and holds.
  void stop() {
    mode = robot::JointMode::kVelocity;
    value = 0;
  }
  bool is_stopped() const { return mode == robot::JointMode::kVelocity && value == 0; }
  bool moves_by_itself() const {
    return mode == robot::JointMode::kEffort || mode == robot::JointMode::kVoltage;
  }
  /// Opens an inner joint's worm: it is driven towards smaller positions.
  bool opens() const { return moves_by_itself() ? value < 0 : velocity < 0; }

  /// For the coming step of `h` [s] of the joint at `start`, whose motor gave `effort` [N m].
  void advance(const ActuatedJoint& joint, double acceleration, double h, const JointMotion& start,
               double effort);
  /// What the motor is asked for then.
  ActuatorRequest request(const ActuatedJoint& joint) const;
  /// The speed [rad/s] in the direction of `value` that still stops at the joint's end.
  double most_speed(const ActuatedJoint& joint, double acceleration, double h,
                    double position_now) const;
};

}  // namespace prehend::simulation
