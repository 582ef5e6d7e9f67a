#include <algorithm>
#include <cmath>
#include <cstdio>

#include "drivers/pg70/driver/driver.h"

namespace prehend::drivers::pg70 {
namespace {

constexpr double kRepress = 0.25;  // s between repetitions of a command that is blocked

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%g", value);
  return text;
}

bool is_near(double a, double b) { return std::abs(a - b) < 1e-9; }

}  // namespace

std::string Driver::refusal_of_motion() const {
  switch (reading_.state) {
    case DriverState::kDisconnected:
      return "the gripper is not connected";
    case DriverState::kConnecting:
      return obstacle_.empty() ? "the gripper does not answer yet" : obstacle_;
    case DriverState::kLost:
      return "the gripper's answers are missing";
    case DriverState::kFault:
      return describe_code(reading_.error_code) + "; acknowledge it first";
    case DriverState::kUnreferenced:
      return "the gripper is not referenced; call /gripper/reference";
    case DriverState::kReferencing:
      return "the gripper is finding its reference";
    default:
      return {};
  }
}

std::string Driver::command(MotionMode mode, double value, double current_limit, Time now) {
  if (mode == MotionMode::kStop) {
    stop(now, "stopped by /gripper/command");
    return {};
  }
  const double no_speed_limit = options_.limits.max_speed;
  return begin_motion(mode, value, no_speed_limit, current_limit, true, now);
}

std::string Driver::move_to(double opening, double speed, double current_limit, Time now,
                            std::uint64_t& ticket) {
  if (!(speed > 0)) return "speed must be positive";
  const std::string refusal =
      begin_motion(MotionMode::kPosition, opening, speed, current_limit, false, now);
  ticket = ticket_;
  return refusal;
}

std::string Driver::begin_motion(MotionMode mode, double value, double speed, double current_limit,
                                 bool continuous, Time now) {
  const Limits& limits = options_.limits;
  if (!std::isfinite(value) || !std::isfinite(speed)) return "the command is not a finite number";
  if (!(std::isfinite(current_limit) && current_limit >= 0)) {
    return "current limit must be finite and not negative";
  }
  if (mode == MotionMode::kPosition && (value < 0 || value > limits.max_opening)) {
    return "opening " + number(value) + " m is outside 0.." + number(limits.max_opening) + " m";
  }
  if (std::string refusal = refusal_of_motion(); !refusal.empty()) return refusal;
  double current =
      current_limit > 0 ? std::min(current_limit, limits.max_current) : limits.nominal_current;
  speed = std::min(speed, limits.max_speed);
  if (mode == MotionMode::kVelocity) {
    value = std::clamp(value, -limits.max_speed, limits.max_speed);
    speed = std::abs(value);
    if (value == 0) {
      stop(now);
      return {};
    }
  }
  if (mode == MotionMode::kCurrent) {
    value = std::clamp(value, -limits.max_current, limits.max_current);
    current = std::abs(value);
  }

  const bool is_repeated = continuous && motion_.continuous && motion_.mode == mode &&
                           is_near(motion_.value, value) && is_near(motion_.current, current) &&
                           motion_.failure.empty();
  last_command_ = now;
  if (is_repeated) {
    ++ticket_;
    const bool wants_more =
        motion_.ended && motion_.blocked && now - motion_.started > to_time(kRepress);
    if (!wants_more) return {};
  } else {
    reading_.blocked = false;
  }
  stopping_.reset();
  ++ticket_;
  motion_ = {.mode = mode,
             .value = value,
             .current = current,
             .continuous = continuous,
             .ended = false,
             .is_repeat = is_repeated,
             .target = mode == MotionMode::kPosition ? value
                       : value < 0                   ? 0.0
                                                     : limits.max_opening,
             .started = now,
             .standing_since = {},
             .end_told = {},
             .failure = {}};
  const std::string problem = transmit(request_of(mode, value, speed, current), now, true);
  if (!problem.empty()) end_motion(problem);
  return problem;
}

Request Driver::request_of(MotionMode mode, double value, double speed, double current) const {
  const auto amperes = static_cast<float>(current);
  if (mode == MotionMode::kCurrent) {
    return Move{.command = options_.current_as_grip ? Command::kMoveGrip : Command::kMoveCurrent,
                .count = 1,
                .values = {static_cast<float>(value)}};
  }
  if (mode == MotionMode::kVelocity && !options_.velocity_as_position) {
    return Move{
        .command = Command::kMoveVelocity, .count = 2, .values = {to_device(value), amperes}};
  }
  return Move{.command = Command::kMovePosition,
              .count = 4,
              .values = {to_device(motion_.target), to_device(speed),
                         to_device(options_.limits.max_acceleration), amperes}};
}

MotionReport Driver::report(std::uint64_t ticket) const {
  using Kind = MotionReport::Kind;
  if (ticket != ticket_) return {Kind::kReplaced, {}};
  if (!motion_.failure.empty()) return {Kind::kFailed, motion_.failure};
  if (!motion_.ended) return {Kind::kRunning, {}};
  return {motion_.blocked ? Kind::kBlocked : Kind::kReached, {}};
}

void Driver::end_motion(const std::string& failure) {
  if (!motion_.ended) motion_.failure = failure;
  motion_.ended = true;
  motion_.continuous = false;
  std::erase_if(outstanding_, [](const Outstanding& o) { return o.is_motion; });
}

std::string Driver::reference(Time now) {
  if (reading_.state != DriverState::kUnreferenced) {
    if (std::string refusal = refusal_of_motion(); !refusal.empty()) return refusal;
  }
  end_motion("the gripper is referenced");
  ++ticket_;
  const std::string problem = transmit(PlainRequest{Command::kReference}, now);
  if (problem.empty()) {
    referencing_ = true;
    motion_.started = now;
    motion_.seen_moving = false;
  }
  update_state();
  return problem;
}

std::string Driver::acknowledge(Time now) {
  if (!link_up_) return "the gripper is not connected";
  fault_told_ = false;
  return transmit(PlainRequest{Command::kAcknowledge}, now);
}

void Driver::update_motion(Time now) {
  if (motion_.continuous && reading_.moving && now - last_command_ > to_time(options_.watchdog)) {
    note_(true, "no gripper command for " + number(options_.watchdog) +
                    " s while moving: CMD STOP is sent");
    return stop(now, "no gripper command came");
  }
  guard_range(now);
  watch_grip();
  watch_unasked_motion(now);
  conclude_end();
}

// Ends are concluded from states that show the jaws at one place; impulse messages, which can be
// lost, late, switched off or false, only make that quicker. How long it stands counts from state
// to state, not by the clock: a computer that was held up has not seen it standing meanwhile.
void Driver::conclude_end() {
  constexpr double kPlace = 5e-4;  // m
  if (motion_.ended || !motion_.accepted) return;
  if (reading_.moving) {
    const auto patience = to_time(2 * options_.state_period);  // the status may come a little later
    if (motion_.end_told && last_state_ - *motion_.end_told > patience) {
      note_(true, "the module said that its motion ended, but states show that it goes on");
      motion_.end_told.reset();
    }
    motion_.seen_moving = true;
    motion_.standing_since.reset();
    reading_.blocked = false;
    return;
  }
  if (last_state_ <= motion_.accepted_at) return;  // says nothing of this motion
  if (!motion_.standing_since || std::abs(reading_.opening - motion_.standing_at) > kPlace) {
    motion_.standing_since = last_state_;
    motion_.standing_at = reading_.opening;
  }
  const Time stood = last_state_ - *motion_.standing_since;
  const bool is_told = motion_.end_told && last_state_ > *motion_.end_told;
  const bool stands = stood > to_time(is_told ? options_.state_period / 2 : options_.blocked_time);
  const double rest = std::abs(reading_.opening - motion_.target);
  if (rest < options_.opening_tolerance && (motion_.seen_moving || stands)) {
    motion_.ended = true;
    reading_.blocked = false;
  } else if (stands) {
    motion_.ended = motion_.blocked = true;
    reading_.blocked = last_state_ - pressed_ <= to_time(options_.blocked_time);
    gripped_at_ = reading_.opening;
  }
}

// E.g. by a command that came late, or from another master.
void Driver::watch_unasked_motion(Time now) {
  constexpr double kPatience = 0.5;  // s, longer than any braking
  const bool is_asked =
      !motion_.ended || stopping_ || reading_.blocked || reading_.state < DriverState::kStanding;
  if (is_asked || !reading_.moving) {
    unasked_since_.reset();
  } else if (!unasked_since_) {
    unasked_since_ = now;
  } else if (now - *unasked_since_ > to_time(kPatience)) {
    unasked_since_.reset();
    note_(true, "the gripper moves although it was not told to: CMD STOP is sent");
    stop(now);
  }
}

// MOVE VEL and MOVE CUR know no target: they are stopped before the end of the range, as to run
// over a soft limit is a fault that has to be acknowledged.
void Driver::guard_range(Time now) {
  const bool has_target = motion_.mode == MotionMode::kPosition ||
                          (motion_.mode == MotionMode::kVelocity && options_.velocity_as_position);
  if (motion_.ended || has_target || !reading_.moving) return;
  const double v = reading_.velocity;
  const double way =
      v * v / (2 * options_.limits.max_acceleration) + std::abs(v) * 2 * options_.state_period;
  const double room = v < 0 ? reading_.opening : options_.limits.max_opening - reading_.opening;
  if (way < room) return;
  note_(false, "CMD STOP before the end of the range");
  stop(now, "stopped before the end of the range");
}

}  // namespace prehend::drivers::pg70
