#pragma once

#include <atomic>
#include <functional>
#include <string>

#include "drivers/wire/time/time.h"
#include "prehend/graph/node.h"

namespace prehend::drivers {

/// Where a device's remarks go: problems become the node's health until `recovered` is called, so
/// that `prehend doctor` and `prehend node list` show them with their mend; the rest is logged.
class DeviceReport {
 public:
  explicit DeviceReport(graph::Node& node) : node_(node) {}
  std::function<void(bool is_problem, const std::string& words)> taker() {
    return [this](bool is_problem, const std::string& words) {
      if (is_problem) {
        problem(words);
      } else {
        node_.log_info("{}", words);
      }
    };
  }
  void recovered(const std::string& words) {
    last_problem_ = Time::max();
    node_.report(graph::Health::kOk, words);
  }
  void problem(const std::string& words) {
    last_problem_ = steady_now();
    node_.report(graph::Health::kError, words);
  }
  /// Of a device that works although there was a problem, such as errors on the wire: recovered
  /// when the last one is older than `seconds`. Call it now and then.
  void recover_when_quiet(double seconds, const std::string& words) {
    const Time last = last_problem_;
    if (last != Time::max() && steady_now() - last > to_time(seconds)) recovered(words);
  }

 private:
  std::atomic<Time> last_problem_ = Time::max();  // max: none since it recovered
  graph::Node& node_;
};

}  // namespace prehend::drivers
