#pragma once

namespace prehend::robot {

/// What a continuous command to a parallel gripper asks for; msgs::GripperCommand has the same.
enum class GripperMode {
  kStop,
  kPosition,  // m, of the opening
  kVelocity,  // m/s, of the opening; negative closes
  kCurrent,   // A, of the motor; negative closes
  kVoltage    // V, at the motor; negative closes
};

/// What a continuous command to joints asks for; msgs::JointCommand has the same. Of a joint that
/// slides m for rad and N for N m.
enum class JointMode {
  kStop,      // brakes and holds
  kPosition,  // rad
  kVelocity,  // rad/s
  kEffort,    // N m, of the joint's motor
  kVoltage    // V, at the joint's motor, > 0 towards greater positions
};

}  // namespace prehend::robot
