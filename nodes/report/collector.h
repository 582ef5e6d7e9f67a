#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "nodes/report/collected.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// Listens to every topic that the report shows.
class Collector {
 public:
  /// What the robot tells of its motion.
  enum class Moves { kGripper, kJoints };
  /// @param pads names of those that it has.
  Collector(graph::Node& node, const std::vector<std::string>& pads, Moves moves);

  /// Waits until the cycle has ended or nothing can be expected any more (no objects, and none come
  /// within `patience`), the node is shut down, or nothing new was seen, planned or done for
  /// `timeout` (wall time). Returns true when the run ended by itself.
  bool wait_for_end(std::chrono::duration<double> timeout, std::chrono::duration<double> patience);

  /// What came so far.
  Collected snapshot() const;

 private:
  template <class Message, class Action>
  void listen(const std::string& topic, const graph::QoS& qos, Action action);
  /// What streams all the time is no sign that the run goes on.
  template <class Message, class Action>
  void follow(const std::string& topic, Action action);
  void on_phase(const msgs::CycleState& state);
  void on_ground_truth(const msgs::GroundTruth& truth);

  graph::Node& node_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  Collected collected_;
  std::optional<std::chrono::steady_clock::time_point> without_objects_since_;
  std::chrono::steady_clock::time_point last_news_;
  std::vector<graph::Subscription> subscriptions_;  // last: they end before the rest goes
};

}  // namespace prehend::nodes
