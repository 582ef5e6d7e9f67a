#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>
#include <tuple>

#include "msgs/graph.pb.h"

namespace prehend::graph {

class PublisherSide;
class SubscriberSide;

/// Where every node publishes its NodeStatistics, latched: the last report is there for whoever
/// asks. The topic does not report on itself.
inline constexpr const char* kStatisticsTopic = "/statistics";

/// Gathers what went over a node's topics, once a second. In the loop's thread only.
class StatisticsReport {
 public:
  /// `publish` completes the report with the node's name and time.
  StatisticsReport(const PublisherSide& publishers, const SubscriberSide& subscribers,
                   std::function<void(msgs::graph::NodeStatistics&)> publish);

  /// To be called often; reports when a second is over, first at once.
  void tick(std::uint64_t malformed_frames, std::uint64_t control_dropped,
            std::uint64_t failed_callbacks);

 private:
  using Time = std::chrono::steady_clock::time_point;
  // topic, is_publisher, which one of several subscriptions to the topic
  using End = std::tuple<std::string, bool, int>;

  void set_rates(msgs::graph::NodeStatistics& report, double elapsed);

  const PublisherSide& publishers_;
  const SubscriberSide& subscribers_;
  const std::function<void(msgs::graph::NodeStatistics&)> publish_;
  Time last_report_{};
  std::map<End, std::uint64_t> last_messages_;
};

}  // namespace prehend::graph
