#pragma once

#include <chrono>
#include <cstdint>
#include <limits>
#include <memory>

namespace prehend::graph {

enum class ClockMode {
  kWall,      ///< the host's system clock
  kSimulated  ///< topic /clock (msgs::Clock), from the simulation or a replay
};

/// The node's time. All functions may be called from any thread; the sleeps throw std::logic_error
/// inside one of the node's callbacks, which must not hold up the others: use a timer there.
class Clock {
 public:
  struct State;
  explicit Clock(std::shared_ptr<State> state);

  ClockMode mode() const;
  /// [ns] Wall: since the Unix epoch. Simulated: the last /clock stamp, 0 before the first one.
  std::int64_t now() const;
  /// Sleeps until now() >= `stamp` [ns]. False when the node was shut down first.
  bool sleep_until(std::int64_t stamp) const;
  /// Sleeps for `duration` of this clock, so a paused simulation pauses the sleeper; before the
  /// first /clock stamp it waits for that too. When the simulated clock jumps back, the duration
  /// begins anew there. False when the node was shut down first.
  bool sleep_for(std::chrono::nanoseconds duration) const;

 private:
  friend class Rate;
  std::shared_ptr<State> state_;
};

/// [ns] from seconds and back, for stamps.
/// What does not fit (beyond 292 years) becomes the nearest that does; NaN becomes 0.
inline std::int64_t nanoseconds(double seconds) {
  const double count = seconds * 1e9;
  if (count >= 9223372036854775807.0) return std::numeric_limits<std::int64_t>::max();
  if (count <= -9223372036854775808.0) return std::numeric_limits<std::int64_t>::min();
  return count == count ? static_cast<std::int64_t>(count) : 0;
}
inline double seconds(std::int64_t stamp) { return static_cast<double>(stamp) * 1e-9; }

}  // namespace prehend::graph
