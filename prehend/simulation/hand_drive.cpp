#include "prehend/simulation/hand_drive.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "prehend/contact/require.h"
#include "prehend/simulation/actuator_registry.h"

namespace prehend::simulation {
namespace {

// Of the joint's own body about its axis [kg m^2], of one that slides its mass.
double inertia_of_link(const RobotBodies& robot, const RobotBodies::Motor& motor) {
  const engines::EngineJoint& joint = robot.joints[static_cast<std::size_t>(motor.joint)];
  const engines::EngineBody& body = robot.bodies[static_cast<std::size_t>(joint.body)];
  if (motor.slides) return body.mass;
  const Eigen::Vector3d axis_B = body.X_WB.linear().transpose() * joint.axis_W;
  const Eigen::Vector3d arm = joint.axis_W.cross(body.X_WB.translation() - joint.anchor_W);
  return axis_B.cwiseAbs2().dot(body.moments) + body.mass * arm.squaredNorm();
}

}  // namespace

HandDrive::HandDrive(const RobotBodies& robot, const HandDriveOptions& options)
    : options_(options) {
  contact::require_positive(options.yield, "HandDriveOptions::yield");
  contact::require_positive(options.sliding_yield, "HandDriveOptions::sliding_yield");
  contact::require_positive(options.response, "HandDriveOptions::response");
  contact::require_positive(options.ramp, "HandDriveOptions::ramp");
  contact::require_positive(options.blocked_time, "HandDriveOptions::blocked_time");
  contact::require(options.holding >= 1, "HandDriveOptions::holding", "at least 1");
  std::map<int, std::size_t> of_finger;
  std::optional<ActuatorRegistry> actuators;  // looked for when one is named
  for (std::size_t m = 0; m < robot.motors.size(); ++m) {
    Motor motor;
    motor.joint = robot.motors[m];
    motor.effort = motor.joint.max_effort;
    if (motor.joint.inner >= 0) {
      motor.inner_mechanics = robot.mechanics[static_cast<std::size_t>(motor.joint.inner)];
    }
    const RobotBodies::Motor& joint = motor.joint;
    const double stiffness =
        joint.max_effort / (joint.slides ? options_.sliding_yield : options_.yield);
    motor.actuated = {
        joint.name,         joint.slides,     joint.lower, joint.upper,
        joint.max_velocity, joint.max_effort, stiffness,   stiffness * options.response};
    double own = robot.mechanics[static_cast<std::size_t>(joint.joint)].rotor_inertia;
    if (joint.model) {
      if (!actuators) actuators.emplace();
      motor.actuator = actuators->make(*joint.model, motor.actuated);
      const ActuatorMechanics mechanics = motor.actuator->mechanics();
      own = joint.gear * joint.gear * mechanics.inertia;
      motor.actuator_state = motor.actuator->initial_state(0);
      if (mechanics.stiffness > 0) motor.actuated.stiffness = mechanics.stiffness;
    }
    motor.inertia = (own + inertia_of_link(robot, joint)) / (joint.gear * joint.gear);
    motors_.push_back(motor);
    const int finger = motor.joint.finger;
    const auto known = of_finger.find(finger);
    if (finger < 0 || known == of_finger.end()) {
      of_finger[finger] = groups_.size();
      groups_.emplace_back();
      groups_.back().motors.push_back(static_cast<int>(m));
    } else {
      groups_[known->second].motors.push_back(static_cast<int>(m));
    }
  }
}

void HandDrive::put_mechanics(std::vector<engines::JointMechanics>& mechanics) const {
  for (const Motor& motor : motors_) {
    if (!motor.actuator) continue;
    const double gear = motor.joint.gear;
    const ActuatorMechanics own = motor.actuator->mechanics();
    engines::JointMechanics& joint = mechanics[static_cast<std::size_t>(motor.joint.joint)];
    joint.rotor_inertia = gear * gear * own.inertia;
    joint.damping = gear * gear * own.damping;
    joint.dry_friction = gear * own.friction;
  }
}

double HandDrive::current(int motor) const {
  const Motor& of = motors_.at(static_cast<std::size_t>(motor));
  return of.actuator ? of.actuator->current(of.actuator_state)
                     : std::numeric_limits<double>::quiet_NaN();
}

double HandDrive::position(const engines::MultibodyState& state, int motor) const {
  const RobotBodies::Motor& joint = motors_.at(static_cast<std::size_t>(motor)).joint;
  double q = state.positions[joint.coordinate];
  if (joint.along >= 0) q += joint.share * state.positions[joint.along_coordinate];
  return joint.gear * q;
}

double HandDrive::velocity(const engines::MultibodyState& state, int motor) const {
  const RobotBodies::Motor& joint = motors_.at(static_cast<std::size_t>(motor)).joint;
  double v = state.velocities[joint.coordinate];
  if (joint.along >= 0) v += joint.share * state.velocities[joint.along_coordinate];
  return joint.gear * v;
}

double HandDrive::effort(const engines::Multibody& system, int motor) const {
  const RobotBodies::Motor& joint = motors_.at(static_cast<std::size_t>(motor)).joint;
  return system.drive_force(joint.joint) / joint.gear;
}

Eigen::VectorXd HandDrive::positions(const engines::MultibodyState& state) const {
  Eigen::VectorXd q(size());
  for (int m = 0; m < size(); ++m) q[m] = position(state, m);
  return q;
}

void HandDrive::begin(const engines::MultibodyState& state) {
  for (int m = 0; m < size(); ++m) {
    Motor& motor = motors_[static_cast<std::size_t>(m)];
    if (motor.actuator) motor.actuator_state = motor.actuator->initial_state(position(state, m));
  }
  hold(state);
}

void HandDrive::hold(const engines::MultibodyState& state) {
  for (int m = 0; m < size(); ++m) {
    Motor& motor = motors_[static_cast<std::size_t>(m)];
    motor.start = motor.target = motor.reference = position(state, m);
    motor.reference_velocity = 0;
    motor.commanded.reset();
  }
  for (Group& group : groups_) group = {group.motors};
}

Eigen::VectorXd HandDrive::targets() const {
  Eigen::VectorXd q(size());
  for (int m = 0; m < size(); ++m) q[m] = motors_[static_cast<std::size_t>(m)].target;
  return q;
}

Eigen::VectorXd HandDrive::most_efforts() const {
  Eigen::VectorXd effort(size());
  for (int m = 0; m < size(); ++m) {
    effort[m] = motors_[static_cast<std::size_t>(m)].joint.max_effort;
  }
  return effort;
}

bool HandDrive::moving() const {
  return std::any_of(groups_.begin(), groups_.end(), [&](const Group& group) {
    return group.share < 1 && group.stuck < options_.blocked_time;
  });
}

bool HandDrive::blocked() const {
  return std::any_of(groups_.begin(), groups_.end(),
                     [&](const Group& group) { return group.stuck >= options_.blocked_time; });
}

bool HandDrive::reached() const {
  return std::all_of(groups_.begin(), groups_.end(),
                     [](const Group& group) { return group.share >= 1; });
}

std::vector<double> HandDrive::progress() const {
  std::vector<double> shares;
  for (const Group& group : groups_) {
    if (group.duration > 0) shares.push_back(group.share);
  }
  return shares;
}

}  // namespace prehend::simulation
