#pragma once

#include <functional>
#include <string>

#include "drivers/wire/health/health.h"
#include "prehend/graph/node.h"

namespace prehend::drivers {

/// Where a driver's words go. Remarks on events are logged. Health is a state: it is told when it
/// changes, and is what `prehend doctor` and `prehend node list` show until it changes again.
class DeviceReport {
 public:
  explicit DeviceReport(graph::Node& node) : node_(node) {}
  std::function<void(bool is_problem, const std::string& words)> taker() {
    return [this](bool is_problem, const std::string& words) {
      node_.log(is_problem ? graph::LogLevel::kWarning : graph::LogLevel::kInfo, words);
    };
  }
  /// For one thread.
  void tell(const Health& health) {
    if (is_told_ && health == told_) return;
    is_told_ = true;
    told_ = health;
    const bool is_ok = health.level == Health::Level::kOk;
    const bool is_warning = health.level == Health::Level::kWarning;
    node_.report(is_ok        ? graph::Health::kOk
                 : is_warning ? graph::Health::kWarning
                              : graph::Health::kError,
                 health.words);
  }

 private:
  graph::Node& node_;
  bool is_told_ = false;
  Health told_;
};

}  // namespace prehend::drivers
