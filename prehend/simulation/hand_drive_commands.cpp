// What one asks of a hand's motors, and what is refused.

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>

#include <fmt/format.h>

#include "prehend/simulation/hand_drive.h"

namespace prehend::simulation {
namespace {

constexpr double kSlack = 1e-4;       // rad, beyond limits
constexpr double kStanding = 2.5e-3;  // of a joint's greatest speed: below it counts as standing

[[noreturn]] void refuse_hand(const std::string& what) { throw std::invalid_argument(what); }

}  // namespace

void HandDrive::move(const HandCommand& command) {
  if (command.position.size() != size()) {
    refuse_hand(
        fmt::format("{} positions for {} joints of the hand", command.position.size(), size()));
  }
  if (!(command.speed > 0 && command.speed <= 1)) refuse_hand("speed must be in (0, 1]");
  if (command.effort.size() != 0 && command.effort.size() != size()) {
    refuse_hand(fmt::format("{} efforts for {} joints of the hand", command.effort.size(), size()));
  }
  for (int m = 0; m < size(); ++m) {
    const RobotBodies::Motor& joint = motors_[static_cast<std::size_t>(m)].joint;
    const double target = command.position[m];
    if (!std::isfinite(target)) refuse_hand("the position of '" + joint.name + "' is not finite");
    if (target < joint.lower - kSlack || target > joint.upper + kSlack) {
      refuse_hand(fmt::format("'{}' at {:.4f} is outside {:.4f} to {:.4f}", joint.name, target,
                              joint.lower, joint.upper));
    }
    if (command.effort.size() == 0) continue;
    const double effort = command.effort[m];
    if (!(effort > 0 && effort <= joint.max_effort * (1 + 1e-9))) {
      refuse_hand(fmt::format("the effort of '{}' must be in (0, {:.3f}], not {}", joint.name,
                              joint.max_effort, effort));
    }
  }
  for (Group& group : groups_) {
    group = {group.motors};
    for (const int m : group.motors) {
      Motor& motor = motors_[static_cast<std::size_t>(m)];
      // From where the loop holds it, so that what it presses with does not leap.
      motor.start = motor.reference;
      motor.commanded.reset();
      motor.target = command.position[m];
      motor.opens = motor.target < motor.start;
      motor.effort = command.effort.size() > 0 ? command.effort[m] : motor.joint.max_effort;
      group.duration = std::max(group.duration, std::abs(motor.target - motor.start) /
                                                    (command.speed * motor.joint.max_velocity));
    }
    group.share = group.duration > 0 ? 0.0 : 1.0;
  }
}

void HandDrive::check(const MotorsCommand& command) const {
  const bool stops = command.mode == robot::JointMode::kStop;
  if (stops ? !command.values.empty() : command.values.size() != command.motors.size()) {
    refuse_hand(fmt::format("{} values for {} joints of the hand{}", command.values.size(),
                            command.motors.size(), stops ? ", which are to stop" : ""));
  }
  for (std::size_t i = 0; i < command.motors.size(); ++i) {
    const Motor& motor = motors_.at(static_cast<std::size_t>(command.motors[i]));
    const RobotBodies::Motor& joint = motor.joint;
    if (command.mode == robot::JointMode::kVoltage && !motor.actuator) {
      refuse_hand(
          fmt::format("'{}' has no motor that a voltage could be given: describe it in the "
                      "hand's file under `motor`",
                      joint.name));
    }
    if (motor.actuator &&
        (command.mode == robot::JointMode::kVoltage || command.mode == robot::JointMode::kEffort) &&
        !motor.actuator->takes(command.mode)) {
      refuse_hand(fmt::format("the actuator {} of '{}' takes no {}", motor.actuator->name(),
                              joint.name,
                              command.mode == robot::JointMode::kVoltage ? "voltage" : "effort"));
    }
    if (stops) continue;
    const double value = command.values[i];
    if (!std::isfinite(value)) refuse_hand("the value for '" + joint.name + "' is not finite");
    if (command.mode == robot::JointMode::kPosition &&
        (value < joint.lower - kSlack || value > joint.upper + kSlack)) {
      refuse_hand(fmt::format("'{}' at {:.4f} is outside {:.4f} to {:.4f}", joint.name, value,
                              joint.lower, joint.upper));
    }
  }
}

void HandDrive::command(const MotorsCommand& command) {
  check(command);
  for (Motor& motor : motors_) {  // what move() began ends where it is
    motor.start = motor.target = motor.reference;
    if (!motor.commanded) motor.reference_velocity = 0;
  }
  for (Group& group : groups_) group = {group.motors};
  for (std::size_t i = 0; i < command.motors.size(); ++i) {
    Motor& motor = motors_[static_cast<std::size_t>(command.motors[i])];
    if (!motor.commanded) {
      motor.commanded.emplace();
      motor.commanded->position = motor.reference;
    }
    if (command.mode == robot::JointMode::kStop) {
      motor.commanded->stop();
    } else {
      motor.commanded->mode = command.mode;
      motor.commanded->value = command.values[i];
    }
  }
}

bool HandDrive::stop_commanded(const engines::MultibodyState& state) {
  bool any = false;
  for (int m = 0; m < size(); ++m) {
    Motor& motor = motors_[static_cast<std::size_t>(m)];
    if (!motor.commanded || motor.commanded->is_stopped()) continue;
    if (std::abs(velocity(state, m)) < kStanding * motor.joint.max_velocity) continue;
    motor.commanded->stop();
    any = true;
  }
  return any;
}

}  // namespace prehend::simulation
