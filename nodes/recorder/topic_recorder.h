#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "msgs/views/view_feed.h"
#include "prehend/graph/node.h"
#include "prehend/recording/split_writer.h"
#include "prehend/recording/topic_filter.h"

namespace prehend {

/// Metadata record with what a recording lacks: topic -> "N lost (...)". Absent when it lacks
/// nothing.
inline constexpr const char* kLossMetadata = "prehend.losses";

/// Writes what arrives on topics of a graph into one recording. Message times: log_time is the
/// node's clock on arrival, publish_time the publisher's. A message's sequence number counts on
/// from the one before on its topic, more than one further where messages of its publisher are
/// missing.
class TopicRecorder {
 public:
  /// Subscribes to `topics`, also those nobody publishes yet, and to all that match a pattern among
  /// them, now and later; without any to all topics. Call open() before the node spins.
  TopicRecorder(graph::Node& node, const std::vector<std::string>& topics);

  /// Creates the file, by another name until finish() (see recording_file.h); throws
  /// recording::McapError when it cannot be written, std::invalid_argument when the options make no
  /// sense.
  void open(const std::string& path, const recording::McapWriterOptions& options,
            const recording::SplitOptions& split);

  /// From now on what is recorded is also written as these views show it. After open().
  void show(std::vector<views::View> views);

  void add(recording::McapAttachment attachment);
  void add(recording::McapMetadata metadata);

  /// Writes a chunk that has become old. False once the file could not be written: then nothing
  /// more will be.
  bool keep_up();

  /// Waits until everything published before the call is in the recording. Ends when nothing more
  /// arrives, or what arrives was published later; at most 10 s for arrivals, and as long as it
  /// takes to write them.
  void drain();

  /// Ends the recording and logs what it holds and what it lacks. Throws
  /// recording::McapError when not all of it could be written.
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
    std::optional<std::size_t> channel;  // empty: no message yet
    std::uint64_t schema_hash = 0;
    std::uint32_t sequence = 0;
    std::int64_t newest = 0;  // publish time of what came last [ns]
    std::map<std::string, std::uint64_t> last_by_sender;
    std::map<std::string, std::uint64_t> missing_by_sender;
    std::uint64_t messages = 0, bytes = 0;
  };

  void record(const std::string& topic);
  void take(Topic& topic, const graph::RawMessage& message);
  void write(Topic& topic, const graph::RawMessage& message, std::uint64_t log_time);
  void write_waiting(Topic& topic);
  void follow_sequence(Topic& topic, const graph::MessageInfo& info);
  void declare_channel(Topic& topic, const graph::RawMessage& message);
  void write_view(const views::ViewChannel& channel, std::int64_t time, const std::string& bytes);
  void wait_for_arrivals(std::int64_t until);
  void wait_until_written();
  std::vector<recording::McapMetadata> losses() const;
  void close();
  void log_summary() const;

  graph::Node& node_;
  const recording::TopicFilter filter_;
  std::mutex mutex_;  // of everything below
  std::string path_;
  std::optional<recording::SplitWriter> writer_;
  std::map<std::string, Topic> topics_;
  std::map<std::string, graph::TopicInfo> infos_;
  struct Shown {
    std::size_t channel = 0;
    std::uint32_t sequence = 0;
  };
  std::optional<views::ViewFeed> feed_;
  std::map<std::string, Shown> shown_;  // by the view's topic
  std::uint64_t log_time_ = 0;          // [ns] of the message that is shown
  std::string failure_;
  bool finished_ = false;
  std::uint64_t not_written_ = 0;  // messages after the failure
};

}  // namespace prehend
