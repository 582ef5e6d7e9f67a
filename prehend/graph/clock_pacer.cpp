#include "prehend/graph/clock_pacer.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

namespace prehend::graph {
namespace {

constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

std::int64_t steady_time() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

double checked_speed(double speed) {
  if (std::isfinite(speed) && speed >= 0) return speed;
  throw std::invalid_argument("the clock's speed must be 0 (as fast as it goes) or more, not " +
                              std::to_string(speed));
}

// a + b without overflow; b >= 0.
std::int64_t sum(std::int64_t a, std::int64_t b) { return a > kNever - b ? kNever : a + b; }

// `value` >= 0 as integer, or kNever where it does not fit.
std::int64_t clamped(long double value) {
  return value < static_cast<long double>(kNever) ? static_cast<std::int64_t>(value) : kNever;
}

}  // namespace

ClockPacer::ClockPacer(ClockPacerOptions options)
    : wall_clock_(options.wall_clock ? std::move(options.wall_clock) : steady_time),
      slice_(options.slice),
      speed_(checked_speed(options.speed)),
      paused_(options.paused),
      limit_(options.start),
      time_0_(options.start),
      wall_0_(wall_clock_()),
      granted_(options.start),
      wanted_(options.start) {
  if (slice_ < 0) throw std::invalid_argument("the clock's slice is negative");
}

bool ClockPacer::is_halted() const { return paused_ && granted_ >= limit_; }

std::int64_t ClockPacer::due(std::int64_t wall) const {
  std::int64_t time = kNever;
  if (speed_ > 0) {
    const auto elapsed = static_cast<long double>(std::max<std::int64_t>(0, wall - wall_0_));
    time = sum(time_0_, clamped(elapsed * static_cast<long double>(speed_)));
  }
  return paused_ ? std::min(time, limit_) : time;
}

std::int64_t ClockPacer::grant(std::int64_t target, std::int64_t wall) {
  wanted_ = target;
  granted_ = position(wall);
  return granted_;
}

// Where the clock stands: what is due and asked for.
std::int64_t ClockPacer::position(std::int64_t wall) const {
  const std::int64_t time = std::min(wanted_, due(wall));
  if (slice_ > 0 && time < wanted_) return granted_;
  return std::max(granted_, time);
}

std::int64_t ClockPacer::advance(std::int64_t target) {
  const std::lock_guard lock(mutex_);
  return grant(target, wall_clock_());
}

// Wall time until more than now is due, at most until `target` is; nothing: a command is needed.
std::optional<std::int64_t> ClockPacer::wall_until(std::int64_t target, std::int64_t wall) const {
  if (is_halted() || speed_ <= 0) return std::nullopt;
  const std::int64_t next = paused_ ? std::min(target, limit_) : target;
  const auto left = static_cast<long double>(next - time_0_) / static_cast<long double>(speed_);
  return std::max<std::int64_t>(
      1, sum(clamped(std::ceil(std::max(left, 0.0L))), 1) - (wall - wall_0_));
}

std::int64_t ClockPacer::wait_for(std::int64_t target, std::chrono::nanoseconds longest) {
  const auto end = std::chrono::steady_clock::now() + longest;
  std::unique_lock lock(mutex_);
  const std::uint64_t commands = commands_;
  while (grant(target, wall_clock_()) < target && commands_ == commands) {
    const auto now = std::chrono::steady_clock::now();
    if (now >= end) break;
    const auto left = wall_until(target, wall_clock_());
    auto until = end;
    if (left && *left < (end - now).count()) until = now + std::chrono::nanoseconds(*left);
    changed_.wait_until(lock, until);
  }
  return granted_;
}

void ClockPacer::begin_stretch(std::int64_t wall, std::int64_t time) {
  wall_0_ = wall;
  time_0_ = time;
  ++commands_;
  changed_.notify_all();
}

void ClockPacer::pause() {
  const std::lock_guard lock(mutex_);
  if (is_halted()) return;
  const std::int64_t wall = wall_clock_();
  limit_ = granted_ = position(wall);
  paused_ = true;
  begin_stretch(wall, limit_);
}

void ClockPacer::resume() {
  const std::lock_guard lock(mutex_);
  if (!paused_) return;
  const std::int64_t wall = wall_clock_();
  const std::int64_t time = position(wall);
  paused_ = false;
  begin_stretch(wall, time);
}

void ClockPacer::step(std::int64_t duration) {
  if (duration <= 0) {
    throw std::invalid_argument("a step must be longer than 0 ns, not " + std::to_string(duration));
  }
  if (slice_ > 0 && duration % slice_ != 0) {
    throw std::invalid_argument("this clock goes in slices of " + std::to_string(slice_) +
                                " ns: a step must be a multiple of that, not " +
                                std::to_string(duration));
  }
  const std::lock_guard lock(mutex_);
  if (!paused_) throw std::invalid_argument("the clock runs: pause it before a step");
  const bool halted = is_halted();
  limit_ = sum(limit_, duration);
  if (halted) begin_stretch(wall_clock_(), granted_);
  ++commands_;
  changed_.notify_all();
}

void ClockPacer::set_speed(double speed) {
  checked_speed(speed);
  const std::lock_guard lock(mutex_);
  if (speed == speed_) return;
  const std::int64_t wall = wall_clock_();
  const std::int64_t time = speed_ > 0 ? std::max(granted_, due(wall)) : granted_;
  speed_ = speed;
  begin_stretch(wall, time);
}

void ClockPacer::restart(std::int64_t time) {
  const std::lock_guard lock(mutex_);
  limit_ = granted_ = wanted_ = time;
  begin_stretch(wall_clock_(), time);
}

bool ClockPacer::give_up_lag(std::chrono::nanoseconds most) {
  const std::lock_guard lock(mutex_);
  if (speed_ <= 0 || is_halted()) return false;
  const std::int64_t wall = wall_clock_();
  const auto behind = static_cast<long double>(due(wall)) - static_cast<long double>(granted_);
  if (behind <= static_cast<long double>(most.count()) * static_cast<long double>(speed_)) {
    return false;
  }
  wall_0_ = wall;
  time_0_ = granted_;
  return true;
}

ClockPacer::State ClockPacer::state() const {
  const std::lock_guard lock(mutex_);
  return {is_halted(), speed_, granted_};
}

}  // namespace prehend::graph
