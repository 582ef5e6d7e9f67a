#include "prehend/graph/clock.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "prehend/graph/link/callback_scope.h"
#include "prehend/graph/link/clock_state.h"

namespace prehend::graph {
namespace {

template <class SystemOrSteady>
std::int64_t count_of() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             SystemOrSteady::now().time_since_epoch())
      .count();
}

// [ns] 146 years, so that sums and differences of two times do not overflow.
constexpr std::int64_t kFurthestTime = std::numeric_limits<std::int64_t>::max() / 2;

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

bool Clock::State::set(std::int64_t stamp) {
  if (stamp < -kFurthestTime || stamp > kFurthestTime) return false;
  {
    const std::lock_guard lock(mutex_);
    if (!started_ || stamp < simulated_) {
      ++restarts_;
      restarted_at_ = stamp;
    }
    simulated_ = stamp;
    started_ = true;
  }
  changed_.notify_all();
  return true;
}

bool Clock::State::is_stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
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
      // In slices, as the system time may be set meanwhile.
      changed_.wait_for(lock, std::min<std::chrono::nanoseconds>(
                                  std::chrono::nanoseconds(stamp - time), std::chrono::seconds(1)));
    } else {
      changed_.wait(lock);
    }
  }
  return false;
}

bool Clock::State::sleep_for(std::int64_t duration,
                             const std::function<bool()>& interrupted) const {
  duration = std::min(duration, kFurthestTime);
  std::unique_lock lock(mutex_);
  if (mode_ == ClockMode::kWall) {  // monotonic: a jump of the system time must not matter
    const auto end = std::chrono::steady_clock::now() + std::chrono::nanoseconds(duration);
    while (!stopped_ && !(interrupted && interrupted())) {
      if (std::chrono::steady_clock::now() >= end) return true;
      changed_.wait_until(lock, end);
    }
    return false;
  }
  std::int64_t begin = simulated_;
  std::uint64_t restarts = restarts_;
  while (!stopped_ && !(interrupted && interrupted())) {
    if (restarts != restarts_) {
      restarts = restarts_;
      begin = restarted_at_;  // the clock may have gone on since
    }
    if (started_ && simulated_ - begin >= duration) return true;
    changed_.wait(lock);
  }
  return false;
}

std::uint64_t Clock::State::restarts() const {
  const std::lock_guard lock(mutex_);
  return restarts_;
}

bool Clock::State::sleep_until_tick(std::int64_t stamp, std::uint64_t restarts) const {
  std::unique_lock lock(mutex_);
  if (mode_ == ClockMode::kWall) {
    const std::chrono::steady_clock::time_point end{std::chrono::nanoseconds(stamp)};
    changed_.wait_until(lock, end, [this] { return stopped_; });
    return !stopped_;
  }
  const auto is_over = [this, stamp, restarts] {
    return stopped_ || restarts != restarts_ || (started_ && simulated_ >= stamp);
  };
  changed_.wait(lock, is_over);
  return !stopped_;
}

void check_may_sleep(const Clock::State& state) {
  const std::string refused = refuse_blocking(state, "sleeping by the node's clock",
                                              "use a timer, or sleep in a thread of your own");
  if (!refused.empty()) throw std::logic_error(refused);
}

Clock::Clock(std::shared_ptr<State> state) : state_(std::move(state)) {}
ClockMode Clock::mode() const { return state_->mode(); }
std::int64_t Clock::now() const { return state_->now(); }
bool Clock::sleep_until(std::int64_t stamp) const {
  check_may_sleep(*state_);
  return state_->sleep_until(stamp, nullptr);
}
bool Clock::sleep_for(std::chrono::nanoseconds duration) const {
  if (duration.count() > 0) check_may_sleep(*state_);
  return state_->sleep_for(duration.count(), nullptr);
}

}  // namespace prehend::graph
