#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/sensors.pb.h"
#include "nodes/replay/delivery_window.h"
#include "prehend/graph/clock_control.h"
#include "prehend/graph/node.h"
#include "prehend/recording/mcap_reader.h"
#include "prehend/recording/topic_filter.h"

namespace prehend {

struct RecordingPlayerOptions {
  std::vector<std::string> topics;  ///< to replay, patterns as in TopicFilter; empty: all
  double rate = 1;                  ///< recorded seconds per wall second, >= 0; 0: see play()
  double start = 0;                 ///< seconds after the recording's beginning, >= 0
  double end = 0;                   ///< seconds after the recording's beginning; 0: to its end
  bool paused = false;              ///< begin paused; /clock/control goes on
  bool publish_clock = true;        ///< publish the recorded time on /clock, serve /clock/control
  bool latch_all = false;           ///< keep the last message of every topic for late subscribers
};

/// Publishes a recording's messages again: same bytes, same stamps, in order of their log times.
/// Topics that were latched are latched again, and what was latched before the start comes first.
/// /clock is made anew from the log times and never replayed; /log, /diagnostics and /statistics,
/// which every node has of its own, and /emergency_stop are left out.
class RecordingPlayer {
 public:
  /// Opens the file and advertises its topics. `pacer` is set to the options' rate and pause.
  /// Throws recording::McapError when it cannot be
  /// read, std::invalid_argument when the options make no sense or a topic of them is not in the
  /// file, naming the nearest one.
  RecordingPlayer(graph::Node& node, const std::string& path, const RecordingPlayerOptions& options,
                  std::shared_ptr<graph::ClockPacer> pacer);

  /// Waits until every topic has a subscriber, at most for `timeout` (wall time) in all. Returns
  /// the topics without one.
  std::vector<std::string> wait_for_subscribers(std::chrono::nanoseconds timeout) const;

  /// Publishes everything once; false when the node was shut down before the end. Damaged parts of
  /// the file are skipped and logged. At rate 0 nothing waits for the wall clock, but for the
  /// subscribers: see DeliveryWindow.
  bool play();

  std::uint64_t published() const { return published_; }

 private:
  struct Topic {
    graph::RawPublisher publisher;
    std::string schema_name, schema_data;
    int header_field = 0;  // number of the message's prehend.msgs.Header, 0: none
  };

  void advertise_chosen();
  void advertise(const recording::McapChannel& channel);
  bool publish_latched_before(std::uint64_t time);
  bool publish(const recording::McapMessage& message);
  bool wait_for(std::uint64_t log_time);
  void tick(std::uint64_t time);
  void set_clock(std::uint64_t time);

  graph::Node& node_;
  const RecordingPlayerOptions options_;
  recording::McapReader reader_;
  recording::TopicFilter filter_;  // of the topics that are advertised
  std::map<std::string, Topic> topics_;
  const std::shared_ptr<graph::ClockPacer> pacer_;
  DeliveryWindow window_;
  graph::Publisher<msgs::Clock> clock_;
  std::optional<graph::ClockControl> clock_control_;
  std::chrono::steady_clock::time_point last_tick_{};
  std::uint64_t clock_time_ = 0;          // on /clock last [ns]
  graph::ClockPacer::State clock_state_;  // on /clock last
  std::uint64_t published_ = 0;
};

}  // namespace prehend
