#pragma once

#include <chrono>
#include <string>

#include "msgs/actions.pb.h"
#include "msgs/safety.pb.h"
#include "prehend/graph/node.h"

namespace prehend::tools {

/// Asks the node emergency_stop of the node's own namespace: what `prehend stop` does, and what the
/// emergency key of an interactive tool does. Made when the tool starts, so that the connection is
/// there when the key is pressed. Any thread but the node's callbacks, as the calls wait.
class EmergencyStop {
 public:
  static constexpr std::chrono::nanoseconds kPatience = std::chrono::seconds(2);

  /// `source`: who asks, as everybody will be told: "prehend jog".
  EmergencyStop(graph::Node& node, std::string source);

  /// Whether there is such a node; without waiting.
  bool is_there() const;
  /// Stops all motion until reset(). `reason` in words: "the space key". Returns "" once the node
  /// has told everybody, else what went wrong, in a line.
  std::string stop(const std::string& reason, std::chrono::nanoseconds patience = kPatience) const;
  /// Allows motion again. Returns "", or why not: what caused the stop persists, or nobody answers.
  std::string reset(std::chrono::nanoseconds patience = kPatience) const;

 private:
  std::string source_;
  graph::ServiceClient<msgs::EmergencyStopRequest, msgs::Acknowledge> stop_;
  graph::ServiceClient<msgs::Empty, msgs::Acknowledge> reset_;
};

}  // namespace prehend::tools
