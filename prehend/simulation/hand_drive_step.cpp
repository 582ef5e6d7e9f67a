// A step of a hand's motors.

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/simulation/dc_motor.h"
#include "prehend/simulation/hand_drive.h"

namespace prehend::simulation {
namespace {

constexpr double kSoftening = 0.15;  // share of the effort over which a finger slows down
constexpr double kLeastPace = 0.02;  // of the speed asked for: it stands

// A motor's drive as that of the engine's joint.
engines::JointDrive joint_drive(const contact::SlideCommand& drive, double h,
                                const RobotBodies::Motor& motor) {
  engines::JointDrive result;
  result.mode = engines::JointDrive::Mode::kPosition;
  result.target = (drive.reference + h * drive.speed) / motor.gear;
  result.target_velocity = drive.speed / motor.gear;
  result.stiffness = motor.gear * motor.gear * drive.stiffness;
  result.damping = motor.gear * motor.gear * drive.damping;
  result.limit = motor.gear * drive.limit;
  result.force = motor.gear * drive.force;
  result.along = motor.along;
  result.share = motor.share;
  return result;
}

}  // namespace

void HandDrive::advance_groups(double h, const engines::Multibody& system) {
  for (Group& group : groups_) {
    double most_pace = group.share < 1 ? std::min(1.0, group.pace + h / options_.ramp) : 0.0;
    bool pressed = false;
    for (const int m : group.motors) {
      const Motor& motor = motors_[static_cast<std::size_t>(m)];
      const double way = motor.target - motor.start;
      if (way == 0) continue;
      const double load = std::copysign(1.0, way) * effort(system, m) / motor.effort;
      const double pace = std::clamp((1 - load) / kSoftening, 0.0, 1.0);
      pressed = pressed || pace < kLeastPace;
      most_pace = std::min(most_pace, pace);
    }
    group.pace = most_pace;
    group.stuck = pressed && group.share < 1 ? group.stuck + h : 0.0;
    if (group.share < 1) group.share = std::min(1.0, group.share + h * group.pace / group.duration);
    for (const int m : group.motors) {
      Motor& motor = motors_[static_cast<std::size_t>(m)];
      if (motor.commanded) continue;
      const double way = motor.target - motor.start;
      motor.reference = motor.start + group.share * way;
      motor.reference_velocity = group.share < 1 ? group.pace * way / group.duration : 0.0;
    }
  }
}

// By its actuator.
contact::SlideCommand HandDrive::driven(Motor& motor, const ActuatorRequest& request, double h,
                                        const JointMotion& start) {
  const contact::SlideCommand drive =
      motor.actuator->drive(request, h, start, motor.actuator_state);
  try {
    contact::validate(drive);
  } catch (const std::invalid_argument& error) {
    throw std::runtime_error(fmt::format("the actuator {} of '{}' cannot be followed: {}",
                                         motor.actuator->name(), motor.joint.name, error.what()));
  }
  return drive;
}

// Of a motor that command() moves.
contact::SlideCommand HandDrive::commanded_drive(Motor& motor, double h, const JointMotion& start,
                                                 double effort) const {
  const double a = acceleration(motor);
  JointReference& reference = *motor.commanded;
  reference.advance(motor.actuated, a, h, start, effort);
  motor.start = motor.target = motor.reference = reference.position;
  motor.reference_velocity = reference.velocity;
  const ActuatorRequest request = reference.request(motor.actuated);
  contact::SlideCommand drive;
  if (motor.actuator) {
    drive = driven(motor, request, h, start);
  } else if (request.mode == robot::JointMode::kEffort) {
    drive.force = request.value;
  } else {
    drive = {0,
             motor.actuated.stiffness,
             request.value - h * request.speed,
             motor.actuated.damping,
             request.speed,
             request.most_effort};
  }
  if (!reference.moves_by_itself() || reference.value == 0) return drive;
  return bounded_in_speed(drive, std::copysign(1.0, reference.value),
                          reference.most_speed(motor.actuated, a, h, start.position),
                          request.most_effort, motor.inertia, h, start.position, start.velocity);
}

void HandDrive::before_step(double h, engines::Multibody& system,
                            const engines::MultibodyState& state) {
  advance_groups(h, system);
  for (int m = 0; m < size(); ++m) {
    Motor& motor = motors_[static_cast<std::size_t>(m)];
    const RobotBodies::Motor& joint = motor.joint;
    engines::JointDrive drive;
    if (motor.commanded) {
      drive = joint_drive(commanded_drive(motor, h, motion(state, m), effort(system, m)), h, joint);
    } else if (motor.actuator) {
      const ActuatorRequest request{robot::JointMode::kPosition, motor.reference,
                                    motor.reference_velocity, joint.max_effort};
      drive = joint_drive(driven(motor, request, h, motion(state, m)), h, joint);
    } else {
      drive.mode = engines::JointDrive::Mode::kPosition;
      drive.target = motor.reference / joint.gear;
      drive.target_velocity = motor.reference_velocity / joint.gear;
      const double stiffness = motor.actuated.stiffness;
      drive.stiffness = joint.gear * joint.gear * stiffness;
      drive.damping = drive.stiffness * options_.response;
      drive.limit = joint.gear * options_.holding * joint.max_effort;
      drive.along = joint.along;
      drive.share = joint.share;
    }
    system.set_drive(joint.joint, drive);
    if (joint.inner < 0) continue;
    // The worm of an inner joint lets nothing turn it back; only its motor does.
    const bool opens =
        motor.commanded ? motor.commanded->opens() : motor.opens && motor.reference_velocity < 0;
    engines::JointMechanics mechanics = motor.inner_mechanics;
    if (!opens) {
      mechanics.lower = std::clamp(state.positions[joint.along_coordinate], mechanics.lower,
                                   mechanics.upper - 1e-6);
    }
    system.set_mechanics(joint.inner, mechanics);
  }
}

void HandDrive::after_step(double h, const engines::Multibody& system,
                           const engines::MultibodyState& state) {
  for (int m = 0; m < size(); ++m) {
    Motor& motor = motors_[static_cast<std::size_t>(m)];
    if (!motor.actuator) continue;
    motor.actuator->observe(h, motion(state, m), effort(system, m), motor.actuator_state);
  }
}

}  // namespace prehend::simulation
