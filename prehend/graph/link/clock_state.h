#pragma once

#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>

#include "prehend/graph/clock.h"

namespace prehend::graph {

/// What a node's Clock and its timers read. All functions may be called from any thread.
struct Clock::State {
 public:
  explicit State(ClockMode mode) : mode_(mode) {}

  ClockMode mode() const { return mode_; }
  /// [ns] what Clock::now() says.
  std::int64_t now() const;
  /// [ns] what timers go by: monotonic on the wall clock, where the system time may jump.
  std::int64_t timer_now() const;
  bool has_started() const;

  /// Takes a /clock stamp; false when it is out of all reason, more than 146 years from the epoch.
  bool set(std::int64_t stamp);
  /// Ends all sleeps, for good.
  void stop();
  bool is_stopped() const;
  /// Lets sleepers look at their `interrupted` again.
  void wake();
  /// Sleeps until now() >= stamp; false when stopped or `interrupted()` first.
  bool sleep_until(std::int64_t stamp, const std::function<bool()>& interrupted) const;
  /// The same for a duration from now or from the first stamp, and anew from where the simulated
  /// clock jumps back to.
  bool sleep_for(std::int64_t duration, const std::function<bool()>& interrupted) const;
  /// How often the simulated clock has started or jumped back.
  std::uint64_t restarts() const;
  /// Sleeps until timer_now() >= stamp, or until restarts() is no longer `restarts`. False when
  /// stopped.
  bool sleep_until_tick(std::int64_t stamp, std::uint64_t restarts) const;

 private:
  const ClockMode mode_;
  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::int64_t simulated_ = 0;
  std::uint64_t restarts_ = 0;
  std::int64_t restarted_at_ = 0;
  bool started_ = false;
  bool stopped_ = false;
};

/// Throws std::logic_error inside one of the node's callbacks.
void check_may_sleep(const Clock::State& state);

}  // namespace prehend::graph
