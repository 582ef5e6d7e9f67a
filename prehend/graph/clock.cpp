#include "prehend/graph/clock.h"

#include "prehend/graph/link/clock_state.h"

namespace prehend::graph {
namespace {

template <class SystemOrSteady>
std::int64_t count_of() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             SystemOrSteady::now().time_since_epoch())
      .count();
}

}  // namespace

std::int64_t Clock::State::now() const {
  if (mode_ == ClockMode::kWall) return count_of<std::chrono::system_clock>();
  const std::lock_guard lock(mutex_);
  return simulated_;
}

std::int64_t Clock::State::timer_now() const {
  return mode_ == ClockMode::kWall ? count_of<std::chrono::steady_clock>() : now();
}

bool Clock::State::has_started() const {
  if (mode_ == ClockMode::kWall) return true;
  const std::lock_guard lock(mutex_);
  return started_;
}

void Clock::State::set(std::int64_t stamp) {
  {
    const std::lock_guard lock(mutex_);
    simulated_ = stamp;
    started_ = true;
  }
  changed_.notify_all();
}

void Clock::State::stop() {
  {
    const std::lock_guard lock(mutex_);
    stopped_ = true;
  }
  changed_.notify_all();
}

void Clock::State::wake() {
  { const std::lock_guard lock(mutex_); }  // so that no sleeper is between its check and its wait
  changed_.notify_all();
}

bool Clock::State::sleep_until(std::int64_t stamp, const std::function<bool()>& interrupted) const {
  std::unique_lock lock(mutex_);
  while (!stopped_ && !(interrupted && interrupted())) {
    const std::int64_t time =
        mode_ == ClockMode::kWall ? count_of<std::chrono::system_clock>() : simulated_;
    if (time >= stamp && (mode_ == ClockMode::kWall || started_)) return true;
    if (mode_ == ClockMode::kWall) {
      changed_.wait_for(lock, std::chrono::nanoseconds(stamp - time));
    } else {
      changed_.wait(lock);
    }
  }
  return false;
}

bool Clock::State::sleep_for(std::int64_t duration,
                             const std::function<bool()>& interrupted) const {
  std::unique_lock lock(mutex_);
  if (mode_ == ClockMode::kWall) {  // monotonic: a jump of the system time must not matter
    const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(duration);
    while (!stopped_ && !(interrupted && interrupted())) {
      if (std::chrono::steady_clock::now() >= end) return true;
      changed_.wait_until(lock, end);
    }
    return false;
  }
  while (!started_ && !stopped_ && !(interrupted && interrupted())) changed_.wait(lock);
  const std::int64_t end = simulated_ + duration;
  lock.unlock();
  return sleep_until(end, interrupted);
}

Clock::Clock(std::shared_ptr<State> state) : state_(std::move(state)) {}
ClockMode Clock::mode() const { return state_->mode(); }
std::int64_t Clock::now() const { return state_->now(); }
bool Clock::sleep_until(std::int64_t stamp) const { return state_->sleep_until(stamp, nullptr); }
bool Clock::sleep_for(std::chrono::nanoseconds duration) const {
  return state_->sleep_for(duration.count(), nullptr);
}

}  // namespace prehend::graph
