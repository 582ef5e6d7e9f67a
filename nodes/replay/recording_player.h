#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "msgs/sensors.pb.h"
#include "prehend/graph/node.h"
#include "prehend/graph/recording/mcap_reader.h"

namespace prehend {

struct RecordingPlayerOptions {
  std::vector<std::string> topics;  ///< to replay; empty: all
  double rate = 1;                  ///< recorded seconds per wall second, >= 0; 0: without waiting
  double start = 0;                 ///< seconds after the recording's beginning, >= 0
  bool publish_clock = true;        ///< publish the recorded time on /clock
  bool latch_all = false;           ///< keep the last message of every topic for late subscribers
};

/// Publishes a recording's messages again: same bytes, same stamps, in order of their log times.
/// Topics that were latched are latched again. /clock is made anew from the log times and never
/// replayed, /log and /diagnostics, which every node has of its own, are left out.
class RecordingPlayer {
 public:
  /// Opens the file and advertises its topics. Throws graph::recording::McapError when it cannot be
  /// read, std::invalid_argument for a negative rate or start, or when a topic of the options is
  /// not in the file, naming the nearest one.
  RecordingPlayer(graph::Node& node, const std::string& path,
                  const RecordingPlayerOptions& options);

  /// Waits until every topic has a subscriber, at most for `timeout` (wall time) in all. Returns
  /// the topics without one.
  std::vector<std::string> wait_for_subscribers(std::chrono::nanoseconds timeout) const;

  /// Publishes everything once; false when the node was shut down before the end. Damaged parts of
  /// the file are skipped and logged.
  bool play();

  std::uint64_t published() const { return published_; }

 private:
  struct Topic {
    graph::RawPublisher publisher;
    int header_field = 0;  // number of the message's prehend.msgs.Header, 0: none
  };

  void advertise(const graph::recording::McapChannel& channel);
  bool wait_for(std::uint64_t log_time);
  void tick(std::uint64_t time);
  void set_clock(std::uint64_t time);

  graph::Node& node_;
  const RecordingPlayerOptions options_;
  graph::recording::McapReader reader_;
  std::map<std::string, Topic> topics_;
  graph::Publisher<msgs::Clock> clock_;
  std::chrono::steady_clock::time_point wall_start_;
  std::chrono::steady_clock::time_point last_tick_{};
  std::uint64_t log_start_ = 0;
  std::uint64_t published_ = 0;
};

}  // namespace prehend
