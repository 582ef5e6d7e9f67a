#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdio>

#include "drivers/sdh/driver/driver.h"

namespace prehend::drivers::sdh {
namespace {

bool is_name_of(const std::string& name, Command command) { return command_named(name) == command; }

std::vector<double> list_of(const AxisValues& values) { return {values.begin(), values.end()}; }

// Two decimals of text, or binary32.
bool is_in_force(const std::vector<double>& said, const std::vector<double>& sent) {
  constexpr double kRounding = 6e-3;
  if (said.size() < sent.size()) return false;
  for (std::size_t i = 0; i < sent.size(); ++i) {
    if (!(std::abs(said[i] - sent[i]) <= kRounding)) return false;
  }
  return true;
}

bool sets(Command command, const std::vector<double>& values) {
  return !values.empty() && command != Command::kMove && command != Command::kStop;
}

}  // namespace

void Driver::strange(const char* what) {
  ++counters_.strange;
  static_cast<void>(what);
}

void Driver::take(const LineReply& reply, Time now) {
  if (!exchange_ || exchange_->is_binary) return strange("a line that nobody asked for");
  if (reply.error) {
    // A stop is sent behind whatever the line had; the code may be of that.
    if (exchange_->command == Command::kStop) return strange("a code before stop is answered");
    return refused(*reply.error, now);
  }
  if (!is_name_of(reply.name, exchange_->command) || reply.axis) {
    return strange("another command's answer");
  }
  const std::string text = reply.text.value_or("");
  answered(numbers_of(text), text, now);
}

void Driver::take(const BinaryReply& reply, Time now) {
  if (!exchange_ || !exchange_->is_binary ||
      static_cast<std::uint8_t>(exchange_->command) != reply.command) {
    return strange("a message that nobody asked for");
  }
  if (reply.status != 0) return refused(reply.status, now);
  if (!reply.has_values()) return strange("a message without values");
  answered(list_of(reply.values), {}, now);
}

// A code has no name: it may be of what a damaged line made of an earlier command. So it is tried
// again before it counts.
void Driver::refused(std::uint8_t code, Time now) {
  if (exchange_->tries < options_.tries &&
      code != static_cast<std::uint8_t>(ReturnCode::kOverTemperature)) {
    ++counters_.strange;
    return ask_again(now);
  }
  const Exchange exchange = *exchange_;
  exchange_.reset();
  const std::string words =
      std::string(to_string(exchange.command)) + " was refused: " + describe_code(code);
  if (connect_ != Connect::kDone) {
    // What an old firmware does not know it does not need.
    const bool is_needed = connect_ == Connect::kStop || connect_ == Connect::kVersion ||
                           connect_ == Connect::kState || connect_ == Connect::kPosition;
    note_(true, words);
    if (!is_needed) connect_goes_on();
    return;
  }
  if (exchange.command == Command::kTemperature) {
    has_temperatures_ = false;
    cycle_ = Cycle::kState;
    return note_(true, words + "; no temperatures are told");
  }
  if (exchange.command == Command::kActualSpeed) {
    cycle_ = Cycle::kState;
    return;
  }
  if (setup_ != Setup::kNone) {
    reading_.error_code = code;
    note_(true, words);
    return stop(now, words);
  }
  if (parks_) parks_ = false;
  note_(true, words);
}

void Driver::answered(const std::vector<double>& values, const std::string& text, Time now) {
  const Exchange exchange = *exchange_;
  if (!take_values(exchange, values, text, now)) {
    ++counters_.strange;
    if (exchange.tries < options_.tries) return ask_again(now);
    exchange_.reset();
    if (setup_ == Setup::kNone) return;
    const std::string words = std::string("the hand does not take ") + to_string(exchange.command) +
                              ": another value is in force";
    note_(true, words);
    return stop(now, words);
  }
  ++counters_.replies;
  exchange_.reset();
  if (connect_ != Connect::kDone) {
    if (exchange.command == Command::kController && exchange.values.empty()) {
      const bool is_pose = !values.empty() && values[0] == 0;
      connect_ = is_pose ? Connect::kProfile : Connect::kSetController;
      return;
    }
    return connect_goes_on();
  }
  switch (exchange.command) {
    case Command::kStop:
      if (stopping_ && !stopping_->answered) stopping_->answered = now;
      return;
    case Command::kCurrentLimit:
      if (setup_ == Setup::kCurrent) setup_ = Setup::kSpeed;
      return;
    case Command::kSpeed:
      if (setup_ == Setup::kSpeed) setup_ = Setup::kTarget;
      return;
    case Command::kTarget:
      if (parks_) {
        parks_ = false;
      } else if (setup_ == Setup::kTarget) {
        setup_ = Setup::kGo;
      }
      return;
    case Command::kMove:
      if (setup_ != Setup::kGo) return;
      setup_ = Setup::kNone;
      reading_.error_code = 0;
      motion_.accepted = true;
      motion_.accepted_at = now;
      if (!values.empty() && values[0] > 0) motion_.duration = values[0];
      cycle_ = Cycle::kState;
      next_cycle_ = now;
      return;
    case Command::kState:
      cycle_ = Cycle::kPosition;
      return;
    case Command::kActualPosition: {
      cycle_ = Cycle::kVelocity;
      ++reading_.states;
      last_state_ = now;
      look_at_axes();
      watch_stop(now);
      update_motion(now);
      return;
    }
    case Command::kActualSpeed: {
      const bool is_due = has_temperatures_ && !reading_.moving &&
                          now - last_temperature_ > to_time(options_.temperature_period);
      cycle_ = is_due || (has_temperatures_ && reading_.temperatures.empty()) ? Cycle::kTemperature
                                                                              : Cycle::kState;
      return;
    }
    case Command::kTemperature:
      last_temperature_ = now;
      cycle_ = Cycle::kState;
      return;
    default:
      return;
  }
}

// False for an answer that cannot be.
bool Driver::take_values(const Exchange& exchange, const std::vector<double>& values,
                         const std::string& text, Time now) {
  switch (exchange.command) {
    case Command::kStop:
    case Command::kMove:
      return true;
    case Command::kVersion: {
      const auto firmware = firmware_of(text);
      if (!firmware) return false;
      firmware_ = *firmware;
      reading_.firmware = firmware->text();
      return true;
    }
    case Command::kController:
      if (exchange.values.empty()) return values.size() == 1;
      return is_in_force(values, exchange.values);
    case Command::kState:
      return take_states(values, now);
    case Command::kActualPosition:
      return take_positions(values);
    case Command::kActualSpeed:
      if (values.size() < kAxes) return false;
      for (std::size_t i = 0; i < kAxes; ++i) {
        if (!std::isfinite(values[i])) return false;
      }
      for (std::size_t i = 0; i < kAxes; ++i) reading_.velocity[i] = kDegree * values[i];
      return true;
    case Command::kSpeedLimit:
    case Command::kAccelerationLimit:
      return take_limits(values);
    case Command::kTemperature: {
      constexpr double kColdest = -40, kHottest = 200;  // degree Celsius
      const bool can_be = !values.empty() && std::ranges::all_of(values, [](double celsius) {
        return celsius > kColdest && celsius < kHottest;
      });
      if (can_be) reading_.temperatures = values;
      return can_be;
    }
    default:
      return !sets(exchange.command, exchange.values) || is_in_force(values, exchange.values);
  }
}

bool Driver::take_states(const std::vector<double>& values, Time) {
  if (values.size() < kAxes) return false;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double value = values[i];
    if (!(value >= 0 && value <= kLastAxisState) || value != std::floor(value)) return false;
  }
  for (std::size_t i = 0; i < kAxes; ++i) {
    reading_.axes[i] = static_cast<AxisState>(static_cast<int>(values[i]));
  }
  return true;
}

bool Driver::take_positions(const std::vector<double>& values) {
  constexpr double kBeyond = 0.2;  // rad beyond the range: no hand shows that
  if (values.size() < kAxes) return false;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double angle = kDegree * values[i];
    if (!(angle > options_.limits.lower[i] - kBeyond &&
          angle < options_.limits.upper[i] + kBeyond)) {
      return false;
    }
  }
  for (std::size_t i = 0; i < kAxes; ++i) reading_.position[i] = kDegree * values[i];
  return true;
}

// Of speed, or of acceleration, whichever is asked for.
bool Driver::take_limits(const std::vector<double>& values) {
  if (values.size() < kAxes) return false;
  const bool of_speed = exchange_->command == Command::kSpeedLimit;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!(std::isfinite(values[i]) && values[i] > 0)) return false;
  }
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (of_speed) {
      max_speed_[i] = std::min(options_.limits.max_speed[i], kDegree * values[i]);
    } else {
      max_acceleration_[i] = kDegree * values[i];
    }
  }
  return true;
}

void Driver::connect_goes_on() {
  switch (connect_) {
    case Connect::kVersion:
      connect_ = firmware_.has_speed_limit() ? Connect::kSpeedLimit : Connect::kAcceleration;
      if (firmware_.has_smooth_ramp()) return;
      if (options_.profile == Profile::kRamp) {
        note_(true, "firmware " + firmware_.text() +
                        " has no ramp that may change on the way: it "
                        "moves by its sine-square profile");
      }
      return;
    case Connect::kSpeedLimit:
      connect_ = firmware_.has_smooth_ramp()   ? Connect::kAccelerationLimit
                 : firmware_.has_controllers() ? Connect::kController
                                               : Connect::kAcceleration;
      return;
    case Connect::kSetController:
      connect_ = Connect::kProfile;
      return;
    case Connect::kAccelerationLimit:
      connect_ = Connect::kController;
      return;
    case Connect::kController:
      connect_ = Connect::kProfile;
      return;
    case Connect::kStop:
      connect_ = Connect::kVersion;
      return;
    case Connect::kProfile:
      connect_ = Connect::kAcceleration;
      return;
    case Connect::kAcceleration:
      connect_ = Connect::kState;
      return;
    case Connect::kState:
      connect_ = Connect::kPosition;
      return;
    case Connect::kPosition:
      connect_ = Connect::kPark;
      return;
    default:
      return;
  }
}

}  // namespace prehend::drivers::sdh
