#pragma once

#include <chrono>
#include <functional>
#include <thread>

namespace prehend::graph {

struct NodeDescription;

/// True once this process was asked to stop: by SIGINT or SIGTERM, or by request_stop. Only in
/// processes that have a StopSignals.
bool stop_requested();

/// Asks this process to stop, as SIGINT would. Any thread.
void request_stop();

/// NodeDescription::stop_time.
std::chrono::milliseconds stop_time_of(const NodeDescription& description);

/// Turns the first SIGINT or SIGTERM, or request_stop, into one call of `on_stop` in a thread of
/// its own; the same signal once more has its default effect, unless it comes within `grace` of the
/// first: then it is ignored, as somebody who hits Ctrl-C twice does not mean to lose what is being
/// written. When it goes, signals are ignored: one that comes during a clean end must not kill. One
/// at a time in a process.
class StopSignals {
 public:
  /// Throws std::system_error when the system refuses.
  explicit StopSignals(std::function<void()> on_stop, std::chrono::milliseconds grace = {});
  ~StopSignals();
  StopSignals(const StopSignals&) = delete;
  StopSignals& operator=(const StopSignals&) = delete;

 private:
  std::thread thread_;
};

}  // namespace prehend::graph
