#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <string>
#include <thread>

#include "prehend/graph/clock_pacer.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// s, simulated: what a continuous command moves is stopped when no other has come for so long.
inline constexpr double kWatchdog = 0.2;

/// A thread that does the simulation's slices as the pacer allows.
class PacedLoop {
 public:
  /// `pacer` begins at 0 with slices of `slice` [ns] and must outlive the object. All functions are
  /// called by the thread: for each slice `step`, which simulates it, and `tell`, which publishes;
  /// `on_pace` with the simulated time [ns] when the clock was paused, resumed or got another
  /// speed. A slice that fails is `node`'s to tell, and the next one follows.
  PacedLoop(graph::Node& node, graph::ClockPacer& pacer, std::int64_t slice,
            std::function<void()> step, std::function<void()> tell,
            std::function<void(std::int64_t)> on_pace);
  ~PacedLoop() { stop(); }

  void start();
  /// Ends the thread and logs what a simulated second took: wall time, and the thread's processor
  /// time for both functions.
  void stop();

 private:
  bool wait_for_pace();
  void work();
  void log_cost() const;

  graph::Node& node_;
  graph::ClockPacer& pacer_;
  const std::int64_t slice_;  // ns
  std::function<void()> step_, tell_;
  std::function<void(std::int64_t)> on_pace_;
  std::atomic<bool> running_{false};
  std::thread thread_;
  // Of the thread alone.
  std::int64_t time_ = 0;  // ns, at the end of the last slice
  graph::ClockPacer::State pace_;
  bool slow_ = false;
  double step_cost_ = 0, tell_cost_ = 0;          // s, of processor
  std::chrono::steady_clock::duration spent_{0};  // of wall time, in slices and between them
};

}  // namespace prehend::nodes
