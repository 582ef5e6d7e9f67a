#pragma once

#include <functional>
#include <thread>

namespace prehend::graph {

/// True once this process was asked to stop: by SIGINT or SIGTERM, or by request_stop. Only in
/// processes that have a StopSignals.
bool stop_requested();

/// Asks this process to stop, as SIGINT would. Any thread.
void request_stop();

/// Turns the first SIGINT or SIGTERM, or request_stop, into one call of `on_stop` in a thread of
/// its own; a second signal has its default effect. When it goes, signals are ignored: one that
/// comes during a clean end must not kill. One at a time in a process.
class StopSignals {
 public:
  /// Throws std::system_error when the system refuses.
  explicit StopSignals(std::function<void()> on_stop);
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

 private:
  std::thread thread_;
};

}  // namespace prehend::graph
