// What the emulated hand makes of its commands.

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "drivers/sdh/emulator/hand.h"

namespace prehend::drivers::sdh {
namespace {

std::uint8_t code(ReturnCode reason) { return static_cast<std::uint8_t>(reason); }

std::string decimals(double value) {
  char text[48];
  std::snprintf(text, sizeof text, "%.2f", value);
  return text;
}

// Open and closed [degree] of the grips that selgrip names; estimates, the firmware's are not
// published.
struct GripPose {
  AxisValues open, closed;
};
constexpr GripPose kGrips[] = {
    {{60, -45, 45, -45, 45, -45, 45}, {60, 10, 20, 10, 20, 10, 20}},   // centrical
    {{0, -45, 45, -45, 45, -45, 45}, {0, 10, -10, 10, -10, 10, -10}},  // parallel
    {{0, -40, 17, -40, 17, -40, 17}, {0, 20, 60, 20, 60, 20, 60}},     // cylindrical
    {{60, -40, 17, -40, 17, -40, 17}, {60, 20, 40, 20, 40, 20, 40}},   // spherical
};

}  // namespace

AxisValues* Hand::setting(Command command) {
  switch (command) {
    case Command::kTarget:
    case Command::kTargetActual:
      return &target_;
    case Command::kSpeed:
    case Command::kSpeedActual:
      return &speed_;
    case Command::kAcceleration:
      return &acceleration_;
    case Command::kCurrentLimit:
      return &current_;
    case Command::kGripCurrent:
      return &grip_current_;
    case Command::kHoldCurrent:
      return &hold_current_;
    default:
      return nullptr;
  }
}

// What the command answers with.
AxisValues Hand::reading(Command command) const {
  AxisValues values{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    switch (command) {
      case Command::kTarget:
        values[i] = target_[i];
        break;
      case Command::kSpeed:
        values[i] = speed_[i];
        break;
      case Command::kAcceleration:
        values[i] = acceleration_[i];
        break;
      case Command::kCurrentLimit:
        values[i] = current_[i];
        break;
      case Command::kGripCurrent:
        values[i] = grip_current_[i];
        break;
      case Command::kHoldCurrent:
        values[i] = hold_current_[i];
        break;
      case Command::kActualPosition:
      case Command::kTargetActual:
        values[i] = motion_.position[i] / kDegree;
        break;
      case Command::kActualSpeed:
      case Command::kSpeedActual:
        values[i] = motion_.velocity[i] / kDegree;
        break;
      case Command::kState:
        values[i] = static_cast<double>(state(i));
        break;
      case Command::kPower:
        values[i] = powered_[i] ? 1 : 0;
        break;
      case Command::kSpeedLimit:
        values[i] = options_.speed_limit[i];
        break;
      case Command::kAccelerationLimit:
        values[i] = options_.acceleration_limit[i];
        break;
      default:
        break;
    }
  }
  return values;
}

std::uint8_t Hand::reason_against(Command command, std::size_t axis, double value) const {
  constexpr double kRounding = 1e-3;  // of binary32 and decimals
  if (!std::isfinite(value)) return code(ReturnCode::kInvalidParameter);
  double least = 0, most = options_.most_current;
  switch (command) {
    case Command::kTarget:
    case Command::kTargetActual:
      least = options_.lower[axis];
      most = options_.upper[axis];
      break;
    case Command::kSpeed:
    case Command::kSpeedActual:
      most = options_.speed_limit[axis];
      if (controller_ != 0) least = -most;
      break;
    case Command::kAcceleration:
      most = options_.acceleration_limit[axis];
      break;
    case Command::kPower:
      most = 1;
      break;
    default:
      break;
  }
  return value < least - kRounding || value > most + kRounding ? code(ReturnCode::kRange) : 0;
}

Hand::Outcome Hand::carry_out_of_axes(Command command, const std::optional<int>& axis,
                                      const std::vector<double>& values) {
  if ((command == Command::kSpeedLimit && !options_.firmware.has_speed_limit()) ||
      (command == Command::kAccelerationLimit && !options_.firmware.has_smooth_ramp())) {
    return {.error = code(ReturnCode::kUnknownCommand)};
  }
  if (values.empty()) return {.values = reading(command)};
  AxisValues* const own = setting(command);
  const bool is_power = command == Command::kPower;
  if (own == nullptr && !is_power) {
    return {.error = 12};  // no parameters expected
  }
  const std::size_t wanted = axis ? 1 : kAxes;
  if (values.size() < wanted) return {.error = code(ReturnCode::kTooFewParameters)};
  if (values.size() > wanted) return {.error = code(ReturnCode::kCommandFormat)};
  const std::size_t first = axis ? static_cast<std::size_t>(*axis) : 0;
  for (std::size_t i = 0; i < wanted; ++i) {
    if (const auto reason = reason_against(command, first + i, values[i])) return {.error = reason};
  }
  for (std::size_t i = 0; i < wanted; ++i) {
    const std::size_t n = first + i;
    if (!is_power) {
      (*own)[n] = values[i];
      continue;
    }
    const bool turns_on = values[i] >= 0.5;
    if (turns_on && is_hot()) return {.error = code(ReturnCode::kOverTemperature)};
    if (turns_on != powered_[n]) {
      sent_[n] = reference_[n] = motion_.position[n] / kDegree;
      velocity_[n] = 0;
      moving_[n] = blocked_[n] = at_limit_[n] = false;
    }
    powered_[n] = turns_on;
    if (!turns_on) grip_.runs = false;
  }
  command_plant();
  return {.values = reading(command)};
}

Hand::Outcome Hand::carry_out_of_hand(Command command, const std::vector<double>& values,
                                      Time now) {
  const auto integer = [&](int& own, int most) -> Outcome {
    if (values.empty()) return {.text = std::to_string(own)};
    if (values.size() > 1) return {.error = code(ReturnCode::kCommandFormat)};
    const double value = values[0];
    if (!(value >= 0 && value <= most) || value != std::floor(value)) {
      return {.error = code(ReturnCode::kRange)};
    }
    own = static_cast<int>(value);
    return {.text = std::to_string(own)};
  };
  switch (command) {
    case Command::kMove:
      return move(now);
    case Command::kStop:
      stop();
      command_plant();
      return {.is_bare = true};
    case Command::kProfile:
      return integer(profile_, options_.firmware.has_smooth_ramp() ? 1 : 0);
    case Command::kController: {
      if (!options_.firmware.has_controllers()) {
        return {.error = code(ReturnCode::kUnknownCommand)};
      }
      int wanted = controller_;
      const Outcome outcome = integer(wanted, 2);
      if (outcome.error == 0 && !values.empty()) select_controller(wanted);
      return outcome;
    }
    case Command::kTemperature: {
      std::string text;
      for (const double celsius : temperatures_) {
        text += (text.empty() ? "" : ",") + decimals(celsius);
      }
      return {.text = text};
    }
    case Command::kVersion:
      return {.text = options_.firmware.text()};
    case Command::kDuration:
      return {.text = decimals(prepare_profile(target_, speed_))};
    case Command::kSelectGrip: {
      const Outcome outcome = integer(grip_.id, 3);
      debug("grip " + std::to_string(grip_.id), now);
      if (outcome.error != 0 || !options_.firmware.is_terse()) return outcome;
      return {.text = decimals(0) + "," + std::to_string(grip_.id)};
    }
    default:
      return grip(values, now);
  }
}

void Hand::select_controller(int controller) {
  constexpr double kSpeed = 40, kAcceleration = 100;  // degree/s, degree/s^2
  stop();
  controller_ = controller;
  speed_.fill(controller == 0 ? kSpeed : 0);
  if (controller != 1) acceleration_.fill(kAcceleration);
  if (controller == 0) target_.fill(0);
}

Hand::Outcome Hand::move(Time now) {
  if (controller_ != 0) return {.error = code(ReturnCode::kInvalidParameter)};
  if (is_hot()) return {.error = code(ReturnCode::kOverTemperature)};
  if (grip_.runs) return {.error = 3};  // already running
  debug("Enabling all axis", now);
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!powered_[i]) reference_[i] = motion_.position[i] / kDegree;
  }
  powered_.fill(true);
  const double duration = begin_profile(target_, speed_);
  ++moves_;
  command_plant();
  if (options_.firmware.is_terse()) return {.text = decimals(duration)};
  return {.is_bare = true};
}

Hand::Outcome Hand::grip(const std::vector<double>& values, Time now) {
  constexpr double kMostSpeed = 100;  // degree/s
  if (values.size() < 2) return {.error = code(ReturnCode::kTooFewParameters)};
  if (values.size() > 2) return {.error = code(ReturnCode::kCommandFormat)};
  const double close = values[0], speed = values[1];
  if (!(close >= 0 && close <= 1) || !(speed > 0 && speed <= kMostSpeed)) {
    return {.error = code(ReturnCode::kRange)};
  }
  if (profile_ != 0 || controller_ != 0) return {.error = code(ReturnCode::kInvalidParameter)};
  if (is_hot()) return {.error = code(ReturnCode::kOverTemperature)};
  const GripPose& pose = kGrips[grip_.id];
  AxisValues target{}, speeds{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    target[i] = pose.open[i] + close * (pose.closed[i] - pose.open[i]);
    speeds[i] = std::min(speed, options_.speed_limit[i]);
    if (!powered_[i]) reference_[i] = motion_.position[i] / kDegree;
  }
  debug("grip current limits", now);
  powered_.fill(true);
  current_ = grip_current_;
  const double duration = begin_profile(target, speeds);
  grip_.runs = true;
  grip_.until = motion_.time + duration;
  ++moves_;
  command_plant();
  return {.text = options_.firmware.is_terse() ? decimals(duration) + "," + decimals(close)
                                               : decimals(close)};
}

}  // namespace prehend::drivers::sdh
