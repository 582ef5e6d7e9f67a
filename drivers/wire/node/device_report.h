#pragma once

#include <functional>
#include <string>

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
        node_.report(graph::Health::kError, words);
      } else {
        node_.log_info("{}", words);
      }
    };
  }
  void recovered(const std::string& words) { node_.report(graph::Health::kOk, words); }
  void problem(const std::string& words) { node_.report(graph::Health::kError, words); }

 private:
  graph::Node& node_;
};

}  // namespace prehend::drivers
