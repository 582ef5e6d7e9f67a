#pragma once

#include <chrono>
#include <cstdint>
#include <memory>

#include "prehend/graph/clock.h"

namespace prehend::graph {

/// Keeps a loop in a thread of one's own at a constant rate of the node's clock:
///     Rate rate(node.clock(), 50);
///     while (rate.sleep()) step();
/// Ticks lie on a grid of whole periods from the start, so that no delay adds up. One thread.
class Rate {
 public:
  /// `hertz`: 1e-9 to 1e9, else throws std::invalid_argument. The first tick is one period from now
  /// (simulated: from the first /clock stamp).
  Rate(const Clock& clock, double hertz);

  /// Sleeps until the next tick. Returns at once when that is over already; the ticks missed by
  /// then merge into one. When the simulated clock jumps back, the period begins anew there. False
  /// when the node was shut down. Throws std::logic_error inside one of the node's callbacks: use a
  /// timer.
  bool sleep();

  /// By how much the work since the tick before ran over the tick that the last sleep() was for;
  /// 0: it was in time.
  std::chrono::nanoseconds overrun() const { return std::chrono::nanoseconds(overrun_); }
  /// Ticks that merged into later ones, in all.
  std::uint64_t missed() const { return missed_; }

 private:
  std::shared_ptr<Clock::State> clock_;
  std::int64_t period_;  // ns
  bool begun_ = false;
  std::int64_t last_ = 0;  // time of the last look
  std::int64_t next_ = 0;
  std::int64_t overrun_ = 0;
  std::uint64_t missed_ = 0;
};

}  // namespace prehend::graph
