#pragma once

#include <atomic>
#include <chrono>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "msgs/actions.pb.h"
#include "msgs/safety.pb.h"
#include "nodes/emergency_stop/required_nodes.h"
#include "nodes/emergency_stop/stop_state.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// Topic /emergency_stop, services /emergency_stop/stop and /emergency_stop/reset. Times are the
/// wall clock's, whatever the graph's does.
class EmergencyStopNode {
 public:
  /// How often its word is repeated: listeners tell its death by the silence.
  static constexpr std::chrono::milliseconds kPeriod{20};

  /// `required`, `registry`: as RequiredNodes.
  EmergencyStopNode(graph::Node& node, const std::vector<std::string>& required,
                    const std::string& registry = "");
  ~EmergencyStopNode();

  /// Required nodes that never came, in words; "": none. Any thread.
  std::string missing() const { return required_.missing(); }

 private:
  msgs::Acknowledge stop(const msgs::EmergencyStopRequest& request);
  msgs::Acknowledge reset();
  void work();
  void tell();
  void report();

  graph::Node& node_;
  RequiredNodes required_;
  graph::Publisher<msgs::EmergencyStop> publisher_;
  std::mutex mutex_;  // guards what follows, and is held while it is told: words keep their order
  StopState state_;
  std::string reported_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  std::atomic<bool> ends_ = false;
  std::thread thread_;
  graph::Service stop_, reset_;
};

}  // namespace prehend::nodes
