#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "prehend/graph/node.h"
#include "prehend/graph/recording/mcap_writer.h"

namespace prehend {

/// Writes what arrives on topics of a graph into one recording. Message times: log_time is the
/// node's clock on arrival, publish_time the publisher's. A message's sequence number counts on
/// from the one before on its topic, more than one further where messages of its publisher are
/// missing.
class TopicRecorder {
 public:
  /// Subscribes to `topics`, also those nobody publishes yet, or to all topics, now and later, when
  /// there are none. Call open() before the node spins.
  TopicRecorder(graph::Node& node, const std::vector<std::string>& topics);

  /// Creates the file; throws graph::recording::McapError when it cannot be written.
  void open(const std::string& path, const graph::recording::McapWriterOptions& options);

  /// Stores a file as it is now. Throws std::runtime_error when it cannot be read.
  void attach(const std::string& path);

  /// Writes a chunk that has become old. Throws once the file could not be written.
  void keep_up();

  /// Waits until nothing more arrives and all that has is in the recording, at most for 1 s.
  void drain();

  /// Ends the recording and logs what it holds and what it lacks.
  void finish();

 private:
  // A message that waits until the graph has said how its topic is published.
  struct Waiting {
    graph::RawMessage message;
    std::uint64_t log_time;  // [ns]
  };
  struct Topic {
    graph::Subscription subscription;
    std::vector<Waiting> waiting;
    std::chrono::steady_clock::time_point waiting_since;
    std::uint16_t channel_id = 0;  // 0: no message yet
    std::uint64_t schema_hash = 0;
    std::uint32_t sequence = 0;
    std::map<std::string, std::uint64_t> last_by_sender;
    std::uint64_t messages = 0, bytes = 0;
  };

  void record(const std::string& topic);
  void take(Topic& topic, const graph::RawMessage& message);
  void write(Topic& topic, const graph::RawMessage& message, std::uint64_t log_time);
  void write_waiting(Topic& topic);
  void declare_channel(Topic& topic, const graph::RawMessage& message);
  std::uint64_t received() const;
  std::uint64_t handled() const;

  graph::Node& node_;
  std::mutex mutex_;  // of everything below
  std::string path_;
  std::optional<graph::recording::McapWriter> writer_;
  std::map<std::string, Topic> topics_;
  std::map<std::string, graph::TopicInfo> infos_;
  std::string failure_;
};

}  // namespace prehend
