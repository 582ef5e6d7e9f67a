#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

namespace prehend::graph {

enum class ClockMode {
  kWall,      ///< the host's system clock
  kSimulated  ///< topic /clock (msgs::Clock), from the simulation or a replay
};

/// The node's time. All functions may be called from any thread.
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
  /// first /clock stamp it waits for that too. False when the node was shut down first.
  bool sleep_for(std::chrono::nanoseconds duration) const;

 private:
  std::shared_ptr<State> state_;
};

/// [ns] from seconds and back, for stamps.
inline std::int64_t nanoseconds(double seconds) { return static_cast<std::int64_t>(seconds * 1e9); }
inline double seconds(std::int64_t stamp) { return static_cast<double>(stamp) * 1e-9; }

}  // namespace prehend::graph
