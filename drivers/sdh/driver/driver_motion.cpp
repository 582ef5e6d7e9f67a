#include <algorithm>
#include <cmath>
#include <cstdio>

#include "drivers/sdh/driver/driver.h"

namespace prehend::drivers::sdh {
namespace {

constexpr double kSlow = 4;    // times as long that an axis stands, where the hand says it moves
constexpr int kMostAgain = 2;  // that a motion which ended elsewhere is begun again

// Axes that stop together: those of a finger.
constexpr std::size_t kFingerOf[kAxes] = {0, 1, 1, 2, 2, 3, 3};

std::string number(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g", value);
  return text;
}

bool is_near(double a, double b) { return std::abs(a - b) < 1e-9; }

}  // namespace

std::string Driver::refusal_of_motion() const {
  switch (reading_.state) {
    case DriverState::kDisconnected:
      return "the hand is not connected";
    case DriverState::kConnecting:
      return "the hand does not answer yet";
    case DriverState::kLost:
      return "the hand's answers are missing";
    case DriverState::kFault:
      return "an axis of the hand is not initialised; switch the hand's supply off and on";
    default:
      return is_stopping() ? "the hand is being stopped" : "";
  }
}

std::string Driver::move_to(const HandGoal& goal, Time now, std::uint64_t& ticket) {
  const std::string refusal = begin_motion(goal, false, now);
  ticket = ticket_;
  return refusal;
}

std::string Driver::begin_motion(const HandGoal& goal, bool continuous, Time now) {
  constexpr double kSlack = 1e-4;  // rad
  const Limits& limits = options_.limits;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!goal.moves[i]) continue;
    const std::string axis = "axis " + std::to_string(i);
    if (!std::isfinite(goal.position[i])) return "the position of " + axis + " is not finite";
    if (goal.position[i] < limits.lower[i] - kSlack ||
        goal.position[i] > limits.upper[i] + kSlack) {
      return axis + " at " + number(goal.position[i]) + " rad is outside " +
             number(limits.lower[i]) + " to " + number(limits.upper[i]);
    }
    if (!(goal.speed[i] > 0)) return "the speed of " + axis + " must be positive";
    if (!(std::isfinite(goal.current[i]) && goal.current[i] >= 0)) {
      return "the current limit of " + axis + " must be finite and not negative";
    }
  }
  if (std::string refusal = refusal_of_motion(); !refusal.empty()) return refusal;
  const Motion before = motion_;
  motion_ = {};
  motion_.continuous = continuous;
  motion_.ended = false;
  motion_.start = reading_.position;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const bool moves = goal.moves[i];
    const double target = moves ? goal.position[i] : held_[i];
    motion_.goal[i] = motion_.target[i] = std::clamp(target, limits.lower[i], limits.upper[i]);
    const double speed = moves ? std::min(goal.speed[i], max_speed_[i]) : 0.0;
    motion_.speed[i] = speed > 0 ? speed : (before.speed[i] > 0 ? before.speed[i] : max_speed_[i]);
    const double asked = moves ? goal.current[i] : before.current[i];
    motion_.current[i] = asked > 0 ? std::min(asked, limits.max_current[i]) : limits.max_current[i];
    const double way = std::abs(motion_.target[i] - motion_.start[i]);
    motion_.duration = std::max(motion_.duration, way / motion_.speed[i]);
  }
  reading_.blocked.fill(false);
  ++ticket_;
  begin_setup(now);
  return {};
}

void Driver::begin_setup(Time) {
  setup_ = Setup::kCurrent;
  motion_.accepted = motion_.seen_moving = false;
  motion_.standing_since.fill(std::nullopt);
  reading_.moving = true;
  held_ = motion_.target;
}

std::string Driver::command(CommandMode mode, const std::array<bool, kAxes>& moves,
                            const AxisValues& values, Time now) {
  const bool goes_on = motion_.continuous && motion_.failure.empty();
  std::array<CommandMode, kAxes> modes{};  // kStop of those that were not told anything
  AxisValues asked{};
  if (goes_on) {
    modes = motion_.modes;
    asked = motion_.asked;
  }
  bool is_repeated = goes_on;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!moves[i]) continue;
    const double value = mode == CommandMode::kStop ? 0 : values[i];
    if (!std::isfinite(value)) {
      return "the value for axis " + std::to_string(i) + " is not finite";
    }
    is_repeated = is_repeated && modes[i] == mode && is_near(asked[i], value);
    modes[i] = mode;
    asked[i] = value;
  }
  if (std::ranges::all_of(modes, [](CommandMode one) { return one == CommandMode::kStop; })) {
    if (reading_.state >= DriverState::kOff) stop(now, "stopped by /hand/command");
    return {};
  }
  last_command_ = now;
  if (is_repeated && !(motion_.ended && has_room())) {
    ++ticket_;
    return {};
  }
  HandGoal goal;
  double time = options_.stretch;  // s, in which all speeds end together
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (modes[i] != CommandMode::kVelocity || asked[i] == 0) continue;
    const double speed = std::min(std::abs(asked[i]), max_speed_[i]);
    const double end = asked[i] > 0 ? options_.limits.upper[i] : options_.limits.lower[i];
    const double room = std::abs(end - reading_.position[i]);
    if (room > options_.tolerance) time = std::min(time, room / speed);
  }
  for (std::size_t i = 0; i < kAxes; ++i) {
    goal.moves[i] = modes[i] != CommandMode::kStop || moves[i];
    goal.speed[i] = max_speed_[i];
    goal.position[i] = modes[i] == CommandMode::kPosition ? asked[i] : reading_.position[i];
    if (modes[i] == CommandMode::kVelocity && asked[i] != 0) {
      goal.speed[i] = std::min(std::abs(asked[i]), max_speed_[i]);
      goal.position[i] += std::copysign(goal.speed[i] * time, asked[i]);
    }
    if (modes[i] == CommandMode::kPosition) continue;
    goal.position[i] =
        std::clamp(goal.position[i], options_.limits.lower[i], options_.limits.upper[i]);
  }
  const std::string refusal = begin_motion(goal, true, now);
  if (!refusal.empty()) return refusal;
  motion_.modes = modes;
  motion_.asked = asked;
  return {};
}

// Some axis that has been given a speed is not at its end.
bool Driver::has_room() const {
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (motion_.modes[i] != CommandMode::kVelocity || motion_.asked[i] == 0) continue;
    const double end = motion_.asked[i] > 0 ? options_.limits.upper[i] : options_.limits.lower[i];
    if (!motion_.blocked[i] && std::abs(end - reading_.position[i]) > options_.tolerance)
      return true;
  }
  return false;
}

// A stretch of a speed that nears its end, while commands go on.
void Driver::draw_out(Time now) {
  if (motion_.ended || !motion_.continuous || !motion_.accepted || setup_ != Setup::kNone) return;
  const bool has_speed = std::ranges::any_of(
      motion_.modes, [](CommandMode mode) { return mode == CommandMode::kVelocity; });
  if (!has_speed || now - motion_.accepted_at < to_time(0.5 * options_.stretch)) return;
  if (now - last_command_ > to_time(options_.watchdog)) return;
  std::array<bool, kAxes> goes{};
  bool any = false;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (motion_.modes[i] != CommandMode::kVelocity || motion_.asked[i] == 0) continue;
    const double end = motion_.asked[i] > 0 ? options_.limits.upper[i] : options_.limits.lower[i];
    if (std::abs(end - reading_.position[i]) > options_.tolerance) goes[i] = any = true;
  }
  if (!any) return;
  const Motion last = motion_;
  const Time commanded = last_command_;
  const std::uint64_t ticket = ticket_;
  motion_.modes.fill(CommandMode::kStop);  // so that it counts as another command
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (last.modes[i] == CommandMode::kPosition) motion_.modes[i] = CommandMode::kPosition;
  }
  command(CommandMode::kVelocity, goes, last.asked, now);
  last_command_ = commanded;
  ticket_ = ticket;
}

MotionReport Driver::report(std::uint64_t ticket) const {
  using Kind = MotionReport::Kind;
  if (ticket != ticket_) return {Kind::kReplaced, {}};
  if (!motion_.failure.empty()) return {Kind::kFailed, motion_.failure};
  if (!motion_.ended) return {Kind::kRunning, {}};
  return {motion_.is_blocked ? Kind::kBlocked : Kind::kReached, {}};
}

void Driver::end_motion(const std::string& failure) {
  if (!motion_.ended) motion_.failure = failure;
  motion_.ended = true;
  motion_.continuous = false;
  motion_.arrived.fill(false);
  setup_ = Setup::kNone;
  if (exchange_ && connect_ == Connect::kDone && exchange_->command != Command::kStop &&
      (!exchange_->values.empty() || exchange_->command == Command::kMove)) {
    exchange_.reset();
  }
}

bool Driver::is_busy(std::size_t axis) const {
  return reading_.axes[axis] == AxisState::kPositioning || reading_.axes[axis] == AxisState::kSpeed;
}

bool Driver::is_there(std::size_t axis) const {
  return std::abs(reading_.position[axis] - motion_.target[axis]) <= options_.tolerance;
}

bool Driver::stands(std::size_t axis, double seconds) const {
  const auto& since = motion_.standing_since[axis];
  return since && last_state_ - *since >= to_time(seconds);
}

// After each whole round of readings: which axes stand, from reading to reading, not by the clock:
// a computer that was held up has not seen them standing meanwhile.
void Driver::look_at_axes() {
  bool any_busy = false;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const bool rests = motion_.ended && motion_.arrived[i] && is_there(i);
    any_busy = any_busy || (is_busy(i) && !rests);
    const double way = std::abs(motion_.goal[i] - motion_.start[i]);
    const double pace = motion_.duration > 0 ? way / motion_.duration : 0;  // rad/s
    const double place = std::clamp(0.25 * pace * options_.blocked_time, 3e-4, 5e-3);
    if (!motion_.standing_since[i] ||
        std::abs(reading_.position[i] - motion_.standing_at[i]) > place) {
      motion_.standing_since[i] = last_state_;
      motion_.standing_at[i] = reading_.position[i];
    }
  }
  if (motion_.accepted && any_busy) motion_.seen_moving = true;
  const bool holds = motion_.ended && reading_.is_blocked();
  if (holds) {
    any_busy = false;
    for (std::size_t i = 0; i < kAxes; ++i) {
      const bool rests = motion_.arrived[i] && is_there(i);
      any_busy = any_busy || (is_busy(i) && !reading_.blocked[i] && !rests);
    }
  }
  reading_.moving = any_busy || !motion_.ended;
}

void Driver::update_motion(Time now) {
  if (connect_ != Connect::kDone) return;
  if (motion_.continuous && !motion_.ended && now - last_command_ > to_time(options_.watchdog)) {
    const bool moves =
        setup_ != Setup::kNone || std::ranges::any_of(reading_.axes, [](AxisState state) {
          return state == AxisState::kPositioning || state == AxisState::kSpeed;
        });
    if (moves) {
      note_(true,
            "no hand command for " + number(options_.watchdog) + " s while moving: stop is sent");
      return stop(now, "no hand command came");
    }
  }
  draw_out(now);
  watch_grip();
  watch_unasked_motion(now);
  if (!motion_.ended && motion_.accepted && setup_ == Setup::kNone &&
      last_state_ > motion_.accepted_at) {
    freeze_fingers(now);
    conclude_end(now);
  }
}

// An axis that does not get on: the hand says so, or it stands although it is told to move.
void Driver::freeze_fingers(Time now) {
  const bool has_begun =
      motion_.seen_moving || now - motion_.accepted_at > to_time(options_.start_time);
  bool changes = false;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (motion_.blocked[i] || is_there(i) || !has_begun) continue;
    const bool is_told = reading_.axes[i] == AxisState::kBlockedClockwise ||
                         reading_.axes[i] == AxisState::kBlockedCounterClockwise;
    const bool is_stuck = is_busy(i) && stands(i, kSlow * options_.blocked_time);
    if (!is_stuck && !(is_told && stands(i, options_.blocked_time))) continue;
    motion_.blocked[i] = true;
    const double way = motion_.goal[i] - motion_.start[i];
    const double share =
        is_near(way, 0) ? 0 : std::clamp((reading_.position[i] - motion_.start[i]) / way, 0.0, 1.0);
    for (std::size_t k = 0; k < kAxes; ++k) {
      if (k == i || kFingerOf[k] != kFingerOf[i] || motion_.blocked[k] || motion_.frozen[k])
        continue;
      motion_.frozen[k] = true;
      motion_.target[k] = motion_.start[k] + share * (motion_.goal[k] - motion_.start[k]);
      changes = changes || std::abs(motion_.target[k] - motion_.goal[k]) > options_.tolerance;
    }
  }
  if (changes) begin_setup(now);
}

void Driver::conclude_end(Time now) {
  if (setup_ != Setup::kNone) return;
  bool all_done = true, any_elsewhere = false;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (motion_.blocked[i]) continue;
    // Short of its target by less than counts, as under load: the hand may never call that an end.
    motion_.arrived[i] = is_there(i) && is_busy(i) && stands(i, kSlow * options_.blocked_time);
    const bool is_done = is_there(i) && (!is_busy(i) || motion_.arrived[i]);
    if (is_done) continue;
    all_done = false;
    const bool has_begun =
        motion_.seen_moving || now - motion_.accepted_at > to_time(options_.start_time);
    any_elsewhere = any_elsewhere || (has_begun && !is_busy(i) && !is_there(i) &&
                                      stands(i, 2 * options_.blocked_time));
  }
  const bool is_blocked = std::ranges::any_of(motion_.blocked, [](bool on) { return on; });
  if (all_done) {
    motion_.ended = true;
    motion_.is_blocked = is_blocked;
    reading_.blocked = motion_.blocked;
    gripped_at_ = reading_.position;
    look_at_axes();
    return;
  }
  if (!any_elsewhere) return;
  if (motion_.again++ < kMostAgain) {  // a command came to harm on its way, or came twice
    ++counters_.unanswered;
    return begin_setup(now);
  }
  stop(now, "the hand ended its motion elsewhere");
}

// What is held must go on to show it: axes where they were blocked.
void Driver::watch_grip() {
  if (!motion_.ended || !reading_.is_blocked()) return;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!reading_.blocked[i]) continue;
    const bool gave_way = std::abs(reading_.position[i] - gripped_at_[i]) > options_.grip_give;
    if (!gave_way && !is_there(i)) continue;
    reading_.blocked[i] = false;
    note_(true, "the grip is lost: axis " + std::to_string(i) + " went from " +
                    number(gripped_at_[i]) + " to " + number(reading_.position[i]) + " rad");
  }
}

// E.g. by a command that came late, or from another master.
void Driver::watch_unasked_motion(Time now) {
  constexpr double kPatience = 0.5;  // s, longer than any braking
  const bool is_asked = !motion_.ended || is_stopping() || !reading_.moving;
  if (is_asked) {
    unasked_since_.reset();
  } else if (!unasked_since_) {
    unasked_since_ = now;
  } else if (now - *unasked_since_ > to_time(kPatience)) {
    unasked_since_.reset();
    note_(true, "the hand moves although it was not told to: stop is sent");
    stop(now);
  }
}

}  // namespace prehend::drivers::sdh
