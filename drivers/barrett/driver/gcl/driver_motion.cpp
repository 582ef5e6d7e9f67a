#include <algorithm>
#include <cmath>

#include "drivers/barrett/driver/gcl/driver.h"

namespace prehend::drivers::barrett::gcl {
namespace {

constexpr double kStill = 5e-4;  // rad between readings: it stands

bool is_near(double a, double b) { return std::abs(a - b) < 1e-9; }

}  // namespace

std::string Driver::move_to(const HandGoal& goal, Time now, std::uint64_t& ticket) {
  const std::string refusal = begin_motion(goal, false, now);
  ticket = ticket_;
  return refusal;
}

std::string Driver::begin_motion(const HandGoal& goal, bool continuous, Time now) {
  const Limits& limits = options_.limits;
  if (std::string refusal = refusal_of_goal(goal, limits); !refusal.empty()) return refusal;
  if (std::string refusal = refusal_of_motion(reading_, is_stopping()); !refusal.empty()) {
    return refusal;
  }
  const Motion before = motion_;
  motion_ = {};
  motion_.continuous = continuous;
  motion_.ended = false;
  for (std::size_t i = 0; i < kAxes; ++i) {
    AxisMotion& axis = motion_.axes[i];
    if (!goal.moves[i]) {
      // Who is not named goes on.
      if (!before.ended && before.axes[i].phase == Phase::kGoing) axis = before.axes[i];
      axis.mode = CommandMode::kStop;
      continue;
    }
    axis.phase = Phase::kGoing;
    axis.target = std::clamp(goal.position[i], limits.lower[i], limits.upper[i]);
    axis.speed = std::min(goal.speed[i], limits.max_speed[i]);
    const double last = before.axes[i].current;
    const double asked = continuous && goal.current[i] == 0 ? last : goal.current[i];
    axis.current = asked > 0 ? std::min(asked, limits.max_current[i]) : limits.max_current[i];
    reading_.blocked[i] = false;
  }
  ++ticket_;
  next_block_ = std::min(next_block_, now);
  look_whether_it_moves();
  return {};
}

std::string Driver::initialise(Time now, std::uint64_t& ticket) {
  ticket = ticket_;
  const bool may = reading_.state == DriverState::kUninitialised ||
                   reading_.state == DriverState::kStanding ||
                   reading_.state == DriverState::kHolding;
  if (!may || is_stopping()) {
    const std::string refusal = refusal_of_motion(reading_, is_stopping());
    return refusal.empty() ? "the hand moves" : refusal;
  }
  begin_initialising(now);
  ticket = ++ticket_;
  return {};
}

void Driver::begin_initialising(Time now) {
  motion_ = {};
  motion_.initialises = true;
  motion_.ended = false;
  is_initialised_ = false;
  reading_.blocked.fill(false);
  linger_until_ = now;
  steps_.push_back({Step::Kind::kInitialise, "HI"});
  look_whether_it_moves();
  update_state();
}

std::string Driver::command(CommandMode mode, const std::array<bool, kAxes>& moves,
                            const AxisValues& values, Time now) {
  const bool goes_on = motion_.continuous && motion_.failure.empty();
  std::array<CommandMode, kAxes> modes{};  // kStop of those that were not told anything
  AxisValues asked{};
  bool is_repeated = goes_on;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (goes_on) {
      modes[i] = motion_.axes[i].mode;
      asked[i] = motion_.axes[i].asked;
    }
    if (!moves[i]) continue;
    const double value = mode == CommandMode::kStop ? 0 : values[i];
    if (!std::isfinite(value))
      return std::string("the value for ") + axis_name(i) + " is not finite";
    is_repeated = is_repeated && modes[i] == mode && is_near(asked[i], value);
    modes[i] = mode;
    asked[i] = value;
  }
  if (std::ranges::all_of(modes, [](CommandMode one) { return one == CommandMode::kStop; })) {
    if (is_connected_) stop(now, "stopped by /hand/command");
    return {};
  }
  last_command_ = now;
  bool any_room = false;
  for (std::size_t i = 0; i < kAxes; ++i) any_room = any_room || (is_repeated && has_room(i));
  if (is_repeated && !(motion_.ended && any_room)) {
    ++ticket_;
    return {};
  }
  HandGoal goal;
  const Limits& limits = options_.limits;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!moves[i] && !(is_repeated && modes[i] != CommandMode::kStop)) continue;
    goal.moves[i] = true;
    goal.speed[i] = limits.max_speed[i];
    goal.position[i] = modes[i] == CommandMode::kPosition ? asked[i] : reading_.position[i];
    if (modes[i] == CommandMode::kPosition) continue;
    if (modes[i] == CommandMode::kVelocity && asked[i] != 0) {
      goal.speed[i] = std::min(std::abs(asked[i]), limits.max_speed[i]);
      goal.position[i] = asked[i] > 0 ? limits.upper[i] : limits.lower[i];
    }
    goal.position[i] = std::clamp(goal.position[i], limits.lower[i], limits.upper[i]);
  }
  const std::string refusal = begin_motion(goal, true, now);
  if (!refusal.empty()) return refusal;
  for (std::size_t i = 0; i < kAxes; ++i) {
    motion_.axes[i].mode = modes[i];
    motion_.axes[i].asked = asked[i];
  }
  return {};
}

// An axis that has been given a speed and is not at its end, nor blocked.
bool Driver::has_room(std::size_t axis) const {
  const AxisMotion& motion = motion_.axes[axis];
  if (motion.mode != CommandMode::kVelocity || motion.asked == 0 || motion.blocked) return false;
  const double end = motion.asked > 0 ? options_.limits.upper[axis] : options_.limits.lower[axis];
  return std::abs(end - reading_.position[axis]) > options_.tolerance;
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
  motion_.continuous = motion_.initialises = motion_.concludes = false;
  for (AxisMotion& axis : motion_.axes) axis.phase = Phase::kNone;
  std::erase_if(steps_, [](const Step& step) { return step.kind == Step::Kind::kInitialise; });
  linger_until_ = {};
}

bool Driver::is_there(std::size_t axis) const {
  return std::abs(reading_.position[axis] - motion_.axes[axis].target) <= options_.tolerance;
}

// From reading to reading, not by the clock: a computer that was held up has not seen it stand.
bool Driver::stands(std::size_t axis) const {
  if (samples_.size() < 2) return false;
  const AxisValues &last = samples_.back().motor, &before = samples_[samples_.size() - 2].motor;
  return std::abs(last[axis] - before[axis]) < kStill;
}

void Driver::look_whether_it_moves() {
  bool any = !motion_.ended;
  // A spread that turns without its motor is one that somebody turns.
  for (std::size_t i = 0; i < kSpread; ++i) {
    any = any || (samples_.size() > 1 && !stands(i));
  }
  reading_.moving = any;
}

void Driver::update_motion(Time now) {
  if (!is_connected_) return;
  if (begins_by_initialising_ && is_initialised_) begins_by_initialising_ = false;  // S says it
  if (begins_by_initialising_ && reading_.state == DriverState::kUninitialised && !is_stopping()) {
    begins_by_initialising_ = false;
    begin_initialising(now);
    ++ticket_;
  }
  if (motion_.continuous && !motion_.ended && now - last_command_ > to_time(options_.watchdog)) {
    note_(true, "no hand command for " + number(options_.watchdog) +
                    " s while moving: the hand is stopped");
    return stop(now, "no hand command came");
  }
  watch_grip();
  watch_unasked_motion(now);
  conclude(now);
}

// A motion to a place ends when the hand has told whether its clutches opened, in Supervisory mode;
// a continuous one waits for the next command in RealTime mode.
void Driver::conclude(Time now) {
  if (motion_.ended || motion_.initialises) return;
  const bool goes = std::ranges::any_of(
      motion_.axes, [](const AxisMotion& axis) { return axis.phase == Phase::kGoing; });
  if (goes) return;
  if (!motion_.continuous && !motion_.concludes) {
    motion_.concludes = true;
    steps_.push_back({Step::Kind::kPosition, "FGET P"});
    steps_.push_back({Step::Kind::kBreakaway, "FGET BD"});
    steps_.push_back({Step::Kind::kPosition, "FGET P"});
    return;
  }
  if (motion_.concludes && (mode_ != Mode::kIdle || !steps_.empty())) return;
  motion_.ended = true;
  motion_.concludes = false;
  linger_until_ = motion_.continuous ? now + to_time(options_.linger) : now;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (motion_.axes[i].phase != Phase::kEnded) continue;
    motion_.axes[i].blocked = motion_.axes[i].blocked || reading_.clutch_open[i];
    reading_.blocked[i] = motion_.axes[i].blocked;
    motion_.is_blocked = motion_.is_blocked || motion_.axes[i].blocked;
    gripped_at_[i] = reading_.position[i];
  }
  look_whether_it_moves();
}

// What is held must go on to show it: axes where they were blocked.
void Driver::watch_grip() {
  if (!motion_.ended || !reading_.is_blocked()) return;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (!reading_.blocked[i]) continue;
    if (std::abs(reading_.position[i] - gripped_at_[i]) <= options_.grip_give) continue;
    reading_.blocked[i] = false;
    note_(true, std::string("the grip is lost: ") + axis_name(i) + " went from " +
                    number(gripped_at_[i]) + " to " + number(reading_.position[i]) + " rad");
  }
}

// E.g. by a command that came late, or by another master.
void Driver::watch_unasked_motion(Time now) {
  constexpr double kPatience = 0.5;  // s, longer than any braking
  const bool is_asked = !motion_.ended || is_stopping() || !reading_.moving;
  if (is_asked) {
    unasked_since_.reset();
  } else if (!unasked_since_) {
    unasked_since_ = now;
  } else if (now - *unasked_since_ > to_time(kPatience)) {
    unasked_since_.reset();
    note_(true, "the hand moves although it was not told to: it is stopped");
    stop(now);
  }
}

}  // namespace prehend::drivers::barrett::gcl
