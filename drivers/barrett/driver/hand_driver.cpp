#include "drivers/barrett/driver/hand_driver.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace prehend::drivers::barrett {

const char* to_string(DriverState state) {
  switch (state) {
    case DriverState::kDisconnected:
      return "disconnected";
    case DriverState::kConnecting:
      return "connecting";
    case DriverState::kLost:
      return "lost";
    case DriverState::kFault:
      return "fault";
    case DriverState::kUninitialised:
      return "not initialised";
    case DriverState::kInitialising:
      return "initialising";
    case DriverState::kStanding:
      return "standing";
    case DriverState::kMoving:
      return "moving";
    case DriverState::kHolding:
      return "holding";
  }
  return "?";
}

bool Reading::is_blocked() const {
  return std::ranges::any_of(blocked, [](bool on) { return on; });
}

std::string refusal_of_motion(const Reading& reading, bool is_stopping) {
  switch (reading.state) {
    case DriverState::kDisconnected:
      return "the hand is not connected";
    case DriverState::kConnecting:
      return "the hand does not answer yet";
    case DriverState::kLost:
      return "the hand's answers are missing";
    case DriverState::kFault:
      return reading.problem.empty()
                 ? "a puck of the hand is in error; switch the hand's supply off and on"
                 : reading.problem;
    case DriverState::kUninitialised:
      return "the hand is not initialised; with nothing between its fingers, call "
             "/hand/initialise";
    case DriverState::kInitialising:
      return "the hand is being initialised";
    default:
      return is_stopping ? "the hand is being stopped" : "";
  }
}

std::string refusal_of_goal(const HandGoal& goal, const Limits& limits) {
  constexpr double kSlack = 1e-4;  // rad
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!goal.moves[i]) continue;
    const std::string axis = axis_name(i);
    if (!std::isfinite(goal.position[i])) return "the position of " + axis + " is not finite";
    if (goal.position[i] < limits.lower[i] - kSlack ||
        goal.position[i] > limits.upper[i] + kSlack) {
      return axis + " at " + number(goal.position[i]) + " rad is outside " +
             number(limits.lower[i]) + " to " + number(limits.upper[i]);
    }
    if (!(goal.speed[i] > 0)) return "the speed of " + axis + " must be positive";
    if (!(std::isfinite(goal.current[i]) && goal.current[i] >= 0)) {
      return "the torque limit of " + axis + " must be finite and not negative";
    }
  }
  return {};
}

void check_limits(const Limits& limits) {
  const auto is_positive = [](double value) { return std::isfinite(value) && value > 0; };
  for (std::size_t i = 0; i < kAxes; ++i) {
    const bool holds = std::isfinite(limits.lower[i]) && std::isfinite(limits.upper[i]) &&
                       limits.lower[i] < limits.upper[i] && is_positive(limits.max_speed[i]) &&
                       is_positive(limits.max_current[i]);
    if (!holds) {
      throw std::invalid_argument(
          "BarrettHand driver: a lower limit must be below its upper one, limits of speed and "
          "torque must be positive");
    }
  }
}

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

}  // namespace prehend::drivers::barrett
