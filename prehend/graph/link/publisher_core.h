#pragma once

#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "prehend/graph/link/frames.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/link/peer_channels.h"

namespace prehend::graph {

/// The part of a publisher that user threads see: messages go into its outbox, and the loop's
/// thread takes them out. Thread-safe.
class PublisherCore : public DropCounter {
 public:
  /// `has_work`: called, under no lock, when the outbox is no longer empty.
  PublisherCore(std::shared_ptr<NodeLink> link, std::string topic, QoS qos,
                std::shared_ptr<const Schema> schema, std::uint64_t id);

  const std::string& topic() const { return topic_; }
  const QoS& qos() const { return qos_; }
  const std::shared_ptr<const Schema>& schema() const { return schema_; }
  std::uint64_t id() const { return id_; }

  /// `stamp` [ns], 0: now.
  void publish(MessageFrames message, std::int64_t stamp);
  bool wait_for_subscribers(std::size_t count, std::chrono::nanoseconds timeout) const;
  PublisherStatistics statistics() const;

  void count_dropped(std::uint64_t messages) override;

  // For the loop's thread:
  void set_drain(std::function<void()> drain);
  std::deque<TopicFrames> take_outbox();
  void set_subscribers(std::size_t count);
  /// Ends waits for ever.
  void stop();

 private:
  void make_room(std::size_t bytes);

  const std::shared_ptr<NodeLink> link_;
  const std::string topic_;
  const QoS qos_;
  const std::shared_ptr<const Schema> schema_;
  const std::uint64_t id_;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::function<void()> drain_;
  std::deque<TopicFrames> outbox_;
  std::size_t outbox_bytes_ = 0;
  std::uint64_t next_sequence_ = 1;
  PublisherStatistics statistics_;
  bool stopped_ = false;
};

}  // namespace prehend::graph
