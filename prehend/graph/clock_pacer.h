#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <functional>
#include <mutex>
#include <optional>

namespace prehend::graph {

struct ClockPacerOptions {
  std::int64_t start = 0;  ///< published time to begin at [ns]
  double speed = 1;        ///< published seconds per wall second; 0: as fast as it goes
  bool paused = false;     ///< begins only with resume() or step()
  /// [ns] Where time moves in slices of this length only, as in a simulation: what the producer
  /// asks for is granted in full or not at all. 0: any time can be published.
  std::int64_t slice = 0;
  /// Wall time [ns] from any origin, never going back; empty: std::chrono::steady_clock.
  std::function<std::int64_t()> wall_clock;
};

/// Says how far whoever makes /clock, a simulation or a replay, may go: maps wall time to
/// published time. Between two commands
///
///   due(wall) = time₀ + speed · (wall − wall₀)
///
/// is computed anew from the last command's (wall₀, time₀) each time, so that errors do not add up.
/// The producer asks for the time it wants to publish next and is granted at most what is due.
/// A producer that is late is granted everything due at once and so catches up.
///
/// All functions may be called from any thread; one thread is the producer.
class ClockPacer {
 public:
  struct State {
    bool paused = false;    ///< false while a step is on its way
    double speed = 1;       ///< as set; holds while paused, too
    std::int64_t time = 0;  ///< granted last [ns]
  };

  /// Throws std::invalid_argument unless the speed is finite and at least 0 and the slice at least
  /// 0.
  explicit ClockPacer(ClockPacerOptions options = {});

  /// The time that may be published now: at most `target`, never less than granted before.
  std::int64_t advance(std::int64_t target);

  /// As advance(), but waits until `target` is granted, for `longest` of wall time, or until a
  /// command has come, whichever is first. By the steady clock, whatever ClockPacerOptions say.
  std::int64_t wait_for(std::int64_t target, std::chrono::nanoseconds longest);

  /// Stops where the time due and asked for stands. Nothing happens when paused already; a step
  /// that is on its way ends.
  void pause();
  /// Goes on at the speed set. Nothing happens when not paused.
  void resume();
  /// While paused: goes on at the speed set for exactly `duration` [ns] and pauses again; steps
  /// that come while one is on its way add up. Throws std::invalid_argument when not paused, or
  /// unless `duration` is positive and a multiple of the slice.
  void step(std::int64_t duration);
  /// Throws std::invalid_argument unless finite and at least 0.
  void set_speed(double speed);

  /// Begins anew at `time`, which may be earlier; pause and speed stay.
  void restart(std::int64_t time);
  /// Where the producer is more than `most` of wall time behind: what is due begins anew at what
  /// was granted last, so that it need not catch up. True when that was so.
  bool give_up_lag(std::chrono::nanoseconds most);

  State state() const;

 private:
  std::int64_t due(std::int64_t wall) const;
  std::int64_t grant(std::int64_t target, std::int64_t wall);
  std::optional<std::int64_t> wall_until(std::int64_t target, std::int64_t wall) const;
  std::int64_t position(std::int64_t wall) const;
  void begin_stretch(std::int64_t wall, std::int64_t time);
  bool is_halted() const;

  const std::function<std::int64_t()> wall_clock_;
  const std::int64_t slice_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::uint64_t commands_ = 0;  // counted, so that a wait notices one
  double speed_;
  bool paused_;           // a step may be on its way
  std::int64_t limit_;    // nothing later is granted while paused_ [ns]
  std::int64_t time_0_;   // of the stretch since the last command [ns]
  std::int64_t wall_0_;   // [ns]
  std::int64_t granted_;  // [ns]
  std::int64_t wanted_;   // what the producer asked for last [ns]
};

}  // namespace prehend::graph
