#include "prehend/simulation/hand_drive.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/contact/require.h"

namespace prehend::simulation {
namespace {

constexpr double kSlack = 1e-4;      // rad, beyond limits
constexpr double kSoftening = 0.15;  // share of the effort over which a finger slows down
constexpr double kLeastPace = 0.02;  // of the speed asked for: it stands

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
  for (std::size_t m = 0; m < robot.motors.size(); ++m) {
    Motor motor;
    motor.joint = robot.motors[m];
    motor.effort = motor.joint.max_effort;
    if (motor.joint.inner >= 0) {
      motor.inner_mechanics = robot.mechanics[static_cast<std::size_t>(motor.joint.inner)];
    }
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

void HandDrive::hold(const engines::MultibodyState& state) {
  for (int m = 0; m < size(); ++m) {
    Motor& motor = motors_[static_cast<std::size_t>(m)];
    motor.start = motor.target = motor.reference = position(state, m);
    motor.reference_velocity = 0;
  }
  for (Group& group : groups_) group = {group.motors};
}

void HandDrive::move(const HandCommand& command) {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument(what); };
  if (command.position.size() != size()) {
    refuse(fmt::format("{} positions for {} joints of the hand", command.position.size(), size()));
  }
  if (!(command.speed > 0 && command.speed <= 1)) refuse("speed must be in (0, 1]");
  if (command.effort.size() != 0 && command.effort.size() != size()) {
    refuse(fmt::format("{} efforts for {} joints of the hand", command.effort.size(), size()));
  }
  for (int m = 0; m < size(); ++m) {
    const RobotBodies::Motor& joint = motors_[static_cast<std::size_t>(m)].joint;
    const double target = command.position[m];
    if (!std::isfinite(target)) refuse("the position of '" + joint.name + "' is not finite");
    if (target < joint.lower - kSlack || target > joint.upper + kSlack) {
      refuse(fmt::format("'{}' at {:.4f} is outside {:.4f} to {:.4f}", joint.name, target,
                         joint.lower, joint.upper));
    }
    if (command.effort.size() == 0) continue;
    const double effort = command.effort[m];
    if (!(effort > 0 && effort <= joint.max_effort * (1 + 1e-9))) {
      refuse(fmt::format("the effort of '{}' must be in (0, {:.3f}], not {}", joint.name,
                         joint.max_effort, effort));
    }
  }
  for (Group& group : groups_) {
    group = {group.motors};
    for (const int m : group.motors) {
      Motor& motor = motors_[static_cast<std::size_t>(m)];
      // From where the loop holds it, so that what it presses with does not leap.
      motor.start = motor.reference;
      motor.target = command.position[m];
      motor.opens = motor.target < motor.start;
      motor.effort = command.effort.size() > 0 ? command.effort[m] : motor.joint.max_effort;
      group.duration = std::max(group.duration, std::abs(motor.target - motor.start) /
                                                    (command.speed * motor.joint.max_velocity));
    }
    group.share = group.duration > 0 ? 0.0 : 1.0;
  }
}

void HandDrive::before_step(double h, engines::Multibody& system,
                            const engines::MultibodyState& state) {
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
      const double way = motor.target - motor.start;
      motor.reference = motor.start + group.share * way;
      motor.reference_velocity = group.share < 1 ? group.pace * way / group.duration : 0.0;
    }
  }
  for (int m = 0; m < size(); ++m) {
    const Motor& motor = motors_[static_cast<std::size_t>(m)];
    const RobotBodies::Motor& joint = motor.joint;
    engines::JointDrive drive;
    drive.mode = engines::JointDrive::Mode::kPosition;
    drive.target = motor.reference / joint.gear;
    drive.target_velocity = motor.reference_velocity / joint.gear;
    const double stiffness =
        joint.max_effort / (joint.slides ? options_.sliding_yield : options_.yield);
    drive.stiffness = joint.gear * joint.gear * stiffness;
    drive.damping = drive.stiffness * options_.response;
    drive.limit = joint.gear * options_.holding * joint.max_effort;
    drive.along = joint.along;
    drive.share = joint.share;
    system.set_drive(joint.joint, drive);
    if (joint.inner < 0) continue;
    // The worm of an inner joint lets nothing turn it back; only its motor does.
    engines::JointMechanics mechanics = motor.inner_mechanics;
    if (!(motor.opens && motor.reference_velocity < 0)) {
      mechanics.lower = std::clamp(state.positions[joint.along_coordinate], mechanics.lower,
                                   mechanics.upper - 1e-6);
    }
    system.set_mechanics(joint.inner, mechanics);
  }
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
