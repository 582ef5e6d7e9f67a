#include <algorithm>
#include <cmath>

#include "drivers/barrett/driver/driver.h"

namespace prehend::drivers::barrett {
namespace {

constexpr int kMostAgain = 2;  // that a motion which does not begin is ordered again
constexpr int kTremblingPolls = 25;
constexpr int kEndedPolls = 2;   // modes in a row that show an end
constexpr double kStill = 5e-4;  // rad between readings: it stands
constexpr double kSlow = 4;      // times TSTOP that an axis stands, where MODE says it moves
constexpr double kMillisecond = 1e-3;

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
  if (std::string refusal = refusal_of_motion(); !refusal.empty()) return refusal;
  const Motion before = motion_;
  motion_ = {};
  motion_.continuous = continuous;
  motion_.ended = false;
  motion_.began = now;
  for (std::size_t i = 0; i < kAxes; ++i) {
    AxisMotion& axis = motion_.axes[i];
    if (!goal.moves[i]) {
      // Who is not named goes on.
      const Phase phase = before.axes[i].phase;
      if (!before.ended && phase != Phase::kNone && phase != Phase::kEnded) axis = before.axes[i];
      axis.mode = CommandMode::kStop;
      continue;
    }
    axis.target = std::clamp(goal.position[i], limits.lower[i], limits.upper[i]);
    axis.speed = std::min(goal.speed[i], limits.max_speed[i]);
    const double last = before.axes[i].current;
    const double asked = continuous && goal.current[i] == 0 ? last : goal.current[i];
    axis.current = asked > 0 ? std::min(asked, limits.max_current[i]) : limits.max_current[i];
    begin_setup(i);
    reading_.blocked[i] = false;
  }
  ++ticket_;
  look_whether_it_moves();
  return {};
}

std::string Driver::initialise(Time now, std::uint64_t& ticket) {
  ticket = ticket_;
  const bool may = reading_.state == DriverState::kUninitialised ||
                   reading_.state == DriverState::kStanding ||
                   reading_.state == DriverState::kHolding;
  if (!may || is_stopping()) {
    const std::string refusal = refusal_of_motion();
    return refusal.empty() ? "the hand moves" : refusal;
  }
  begin_initialising(Motion::Kind::kInitialiseFingers, now);
  ticket = ++ticket_;
  return {};
}

// The fingers first: they may stand in the spread's way (BHand API).
void Driver::begin_initialising(Motion::Kind kind, Time now) {
  motion_ = {};
  motion_.kind = kind;
  motion_.ended = false;
  motion_.began = now;
  is_initialised_ = false;
  reading_.blocked.fill(false);
  for (std::size_t i = 0; i < kAxes; ++i) {
    if ((i == kSpread) != (kind == Motion::Kind::kInitialiseSpread)) continue;
    motion_.axes[i].current = options_.limits.max_current[i];
    motion_.axes[i].speed = options_.limits.max_speed[i];
    begin_setup(i);
  }
  look_whether_it_moves();
  update_state();
}

// What a motion must not exceed is set and read back before it begins.
void Driver::begin_setup(std::size_t axis) {
  AxisMotion& motion = motion_.axes[axis];
  motion.phase = Phase::kSetup;
  motion.ended_polls = 0;
  Puck& puck = pucks_[axis];
  std::erase_if(puck.steps, [](const Step& step) { return step.kind == Step::Kind::kMotion; });
  if (puck.asked && puck.asked->kind == Step::Kind::kMotion) puck.asked.reset();
  const double unit = options_.gearing.counts_per_radian(axis) * kMillisecond;
  // Down to whole counts, as a limit; the slowest there is, is one.
  const auto speed = std::max<std::int32_t>(1, static_cast<std::int32_t>(motion.speed * unit));
  const auto torque = std::max<std::int32_t>(1, static_cast<std::int32_t>(motion.current));
  std::vector<Step> steps{{Property::kMostTorque, torque, Step::Kind::kMotion}};
  if (motion_.initialises()) {
    const auto opens =
        static_cast<std::int32_t>(std::min(options_.initial_velocity, motion.speed * unit));
    steps.push_back({Property::kInitialVelocity, -std::max(1, opens), Step::Kind::kMotion});
  } else {
    steps.push_back({Property::kMostVelocity, speed, Step::Kind::kMotion});
    steps.push_back({Property::kDefaultPosition, counts(axis, motion.target), Step::Kind::kMotion});
  }
  puck.steps.insert(puck.steps.begin(), steps.begin(), steps.end());
}

// All axes that are set up begin together.
void Driver::go(Time now) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Puck& puck = pucks_[i];
    if (motion_.axes[i].phase != Phase::kSetup) continue;
    const bool is_asked = puck.asked && puck.asked->kind == Step::Kind::kMotion;
    const bool waits = std::ranges::any_of(
        puck.steps, [](const Step& step) { return step.kind == Step::Kind::kMotion; });
    if (is_asked || waits) return;
  }
  const Command command = motion_.initialises() ? Command::kInitialise : Command::kMove;
  for (std::size_t i = 0; i < kAxes; ++i) {
    AxisMotion& axis = motion_.axes[i];
    if (axis.phase != Phase::kSetup) continue;
    order(i, Property::kCommand, static_cast<int>(command));
    axis.phase = Phase::kCommanded;
    axis.commanded = axis.standing_since = now;
    axis.standing_at = reading_.position[i];
    axis.ended_polls = 0;
    pucks_[i].next_cycle = now;  // its mode is asked for now
  }
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
    const bool is_new = moves[i] || (is_repeated && modes[i] != CommandMode::kStop);
    if (!is_new) continue;
    goal.moves[i] = true;
    goal.speed[i] = limits.max_speed[i];
    goal.position[i] = modes[i] == CommandMode::kPosition ? asked[i] : reading_.position[i];
    if (modes[i] == CommandMode::kPosition) continue;
    if (modes[i] == CommandMode::kVelocity && asked[i] != 0) {
      goal.speed[i] = std::min(std::abs(asked[i]), limits.max_speed[i]);
      goal.position[i] += std::copysign(goal.speed[i] * options_.stretch, asked[i]);
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

// A stretch of a speed that nears its end, while commands go on.
void Driver::draw_out(Time now) {
  if (motion_.ended || !motion_.continuous) return;
  if (now - last_command_ > to_time(options_.watchdog)) return;
  for (std::size_t i = 0; i < kAxes; ++i) {
    AxisMotion& axis = motion_.axes[i];
    const bool is_under_way = axis.phase == Phase::kGoing || axis.phase == Phase::kEnded;
    if (!is_under_way || !has_room(i)) continue;
    if (now - axis.commanded < to_time(0.5 * options_.stretch)) continue;
    const double way = std::copysign(axis.speed * options_.stretch, axis.asked);
    axis.target =
        std::clamp(reading_.position[i] + way, options_.limits.lower[i], options_.limits.upper[i]);
    axis.again = 0;
    begin_setup(i);
  }
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
  for (AxisMotion& axis : motion_.axes) axis.phase = Phase::kNone;
  for (Puck& puck : pucks_) {
    std::erase_if(puck.steps, [](const Step& step) { return step.kind == Step::Kind::kMotion; });
    if (puck.asked && puck.asked->kind == Step::Kind::kMotion) puck.asked.reset();
  }
}

bool Driver::is_busy(std::size_t axis) const {
  return modes_[axis] != Mode::kIdle && modes_[axis] != Mode::kPosition;
}

bool Driver::is_there(std::size_t axis) const {
  return std::abs(reading_.position[axis] - motion_.axes[axis].target) <= options_.tolerance;
}

// From reading to reading, not by the clock: a computer that was held up has not seen it stand.
bool Driver::stands(std::size_t axis) const {
  const auto& samples = pucks_[axis].samples;
  if (samples.size() < 2) return false;
  return std::abs(samples.back().motor - samples[samples.size() - 2].motor) < kStill;
}

void Driver::look_whether_it_moves() {
  bool any = !motion_.ended;
  for (std::size_t i = 0; i < kAxes; ++i) {
    // What moves without its motor is a spread that somebody turns.
    any = any || is_busy(i) || (i != kSpread && pucks_[i].samples.size() > 1 && !stands(i));
  }
  reading_.moving = any;
}

// After each mode that was asked for behind the motion's order.
void Driver::look_at_axis(std::size_t axis, Time now) {
  AxisMotion& motion = motion_.axes[axis];
  if (motion.phase != Phase::kCommanded && motion.phase != Phase::kGoing) return;
  const Puck& puck = pucks_[axis];
  if (puck.mode_asked <= motion.commanded) return;
  const double position = reading_.position[axis];
  if (std::abs(position - motion.standing_at) > kStill) {
    motion.standing_at = position;
    motion.standing_since = now;
  }
  if (is_busy(axis)) {
    motion.phase = Phase::kGoing;
    motion.ended_polls = 0;
    const double patience = kSlow * options_.stall_time;
    if (motion_.initialises() || now - motion.standing_since < to_time(patience)) return;
    note_(true, std::string(axis_name(axis)) + " stands, but its puck says that it moves: MODE 0");
    order(axis, Property::kMode, static_cast<int>(Mode::kIdle));
    motion.standing_since = now;
    return;
  }
  if (puck.last_position <= motion.commanded) return;
  ++motion.ended_polls;
  // A late answer may say so of a motor that moves; one that trembles is believed in the end.
  const bool is_ended = motion.ended_polls >= (stands(axis) ? kEndedPolls : kTremblingPolls);
  if (!is_ended) return;
  const bool is_done = motion_.initialises() ? motion.phase == Phase::kGoing
                                             : motion.phase == Phase::kGoing || is_there(axis);
  if (!is_done) return;  // it has not begun: update_motion looks at the time
  motion.phase = Phase::kEnded;
  motion.blocked = !motion_.initialises() && (!is_there(axis) || reading_.clutch_open[axis]);
}

void Driver::update_motion(Time now) {
  if (!is_connected_) return;
  if (begins_by_initialising_ && reading_.states > 0 &&
      reading_.state == DriverState::kUninitialised && !is_stopping()) {
    begins_by_initialising_ = false;
    begin_initialising(Motion::Kind::kInitialiseFingers, now);
    ++ticket_;
  }
  if (motion_.continuous && !motion_.ended && now - last_command_ > to_time(options_.watchdog)) {
    note_(true, "no hand command for " + number(options_.watchdog) +
                    " s while moving: the hand is stopped");
    return stop(now, "no hand command came");
  }
  draw_out(now);
  watch_grip();
  watch_unasked_motion(now);
  if (motion_.ended) return;
  go(now);
  for (std::size_t i = 0; i < kAxes; ++i) {
    AxisMotion& axis = motion_.axes[i];
    if (axis.phase != Phase::kCommanded) continue;
    if (now - axis.commanded < to_time(options_.begin_time)) continue;
    if (axis.again++ < kMostAgain) {  // the order came to harm on its way
      ++counters_.unanswered;
      begin_setup(i);
      continue;
    }
    const std::string words = std::string(axis_name(i)) + " does not begin its motion";
    note_(true, words);
    return stop(now, words);
  }
  conclude(now);
}

void Driver::conclude(Time now) {
  bool is_blocked = false;
  for (const AxisMotion& axis : motion_.axes) {
    if (axis.phase != Phase::kNone && axis.phase != Phase::kEnded) {
      if (!motion_.initialises() || now - motion_.began < to_time(options_.initialise_time)) return;
      note_(true, "the hand does not end its initialisation");
      return stop(now, "the hand did not end its initialisation in time");
    }
    is_blocked = is_blocked || axis.blocked;
  }
  if (motion_.initialises()) return conclude_initialising(now);
  motion_.ended = true;
  motion_.is_blocked = is_blocked;
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (motion_.axes[i].phase != Phase::kEnded) continue;
    reading_.blocked[i] = motion_.axes[i].blocked;
    gripped_at_[i] = reading_.position[i];
  }
  look_whether_it_moves();
}

void Driver::conclude_initialising(Time now) {
  constexpr double kZero = 0.1;  // rad: the open stop
  for (std::size_t i = 0; i < kAxes; ++i) {
    if (motion_.axes[i].phase != Phase::kEnded || std::abs(reading_.position[i]) < kZero) continue;
    const std::string words = std::string("after its initialisation ") + axis_name(i) + " is at " +
                              number(reading_.position[i]) + " rad, not at its zero";
    note_(true, words);
    return stop(now, words);
  }
  const std::uint64_t ticket = ticket_;
  if (motion_.kind == Motion::Kind::kInitialiseFingers) {
    begin_initialising(Motion::Kind::kInitialiseSpread, now);
    ticket_ = ticket;
    return;
  }
  motion_.ended = true;
  is_initialised_ = true;
  for (std::size_t i = 0; i < kAxes; ++i) {
    pucks_[i].gauge_rest = pucks_[i].gauge;
    reading_.effort[i] = 0;
  }
  note_(false, "the hand is initialised");
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
    note_(true, "the hand moves although it was not told to: it is stopped");
    stop(now);
  }
}

}  // namespace prehend::drivers::barrett
