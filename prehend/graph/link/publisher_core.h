#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "prehend/graph/link/frames.h"
#include "prehend/graph/link/node_link.h"
#include "prehend/graph/link/peer_channels.h"

namespace prehend::graph {

class SubscriptionCore;

/// The part of a publisher that user threads see. Subscribers of this process get each message at
/// once, by pointer; for the others it goes into the outbox, which is emptied in the loop's thread.
/// Thread-safe.
class PublisherCore : public DropCounter {
 public:
  PublisherCore(std::shared_ptr<NodeLink> link, std::string topic, QoS qos,
                std::shared_ptr<const Schema> schema, std::uint64_t id);

  const std::string& topic() const { return head_.topic; }
  const TopicHead& head() const { return head_; }
  const QoS& qos() const { return qos_; }
  const std::shared_ptr<const Schema>& schema() const { return schema_; }
  std::uint64_t id() const { return id_; }

  /// See Publisher. Those that take a `message` may take it apart.
  void publish_copy(const google::protobuf::Message& message);
  void publish_moved(google::protobuf::Message& message);
  void publish_apart(google::protobuf::Message& message, SharedBytes payload,
                     std::shared_ptr<Slab> slab);
  void publish_shared(std::shared_ptr<const google::protobuf::Message> message);
  void publish_each(std::span<const google::protobuf::Message* const> messages);
  /// `stamp` [ns], 0: now.
  void publish(EncodedMessage message, std::int64_t stamp);
  /// Shared memory for a payload, or null when it had better be on the heap.
  std::shared_ptr<Slab> slab_for(std::size_t bytes) const;

  bool wait_for_subscribers(std::size_t count, std::chrono::nanoseconds timeout) const;
  PublisherStatistics statistics() const;

  void count_dropped(std::uint64_t messages) override;
  void count_waiting(std::uint64_t messages, std::uint64_t bytes) override;

  // For the loop's thread:
  void set_drain(std::function<void()> drain);
  struct Taken {
    std::deque<OutgoingMessage> messages;
    std::uint64_t last_sequence = 0;  ///< of all that were published, whether kept or not
  };
  Taken take_outbox();
  /// Who is to be served through the outbox: `keeps`, anybody at all or the history;
  /// `slab_readers`, somebody who reads shared memory.
  void set_outbox_use(bool keeps, bool slab_readers);
  void set_subscribers(std::size_t count);
  /// Hands everything published from now on to a subscription of this process. Not twice. `history`
  /// comes first, with what waits in the outbox since it was written down, the last `depth` of all
  /// that; null: nothing of the past.
  void add_local(const std::shared_ptr<SubscriptionCore>& subscription,
                 const std::deque<OutgoingMessage>* history, std::size_t depth);
  void remove_local(std::uint64_t subscription);
  /// Ends waits for ever, and hands nothing over any more.
  void stop();

 private:
  using Message = google::protobuf::Message;

  bool has_local() const;
  std::shared_ptr<SlabPool> pool() const;
  std::shared_ptr<const Content> content_of(const Message& message) const;
  std::shared_ptr<const Content> content_of_copy(const Message& message) const;
  void publish_content(std::shared_ptr<const Content> content, std::int64_t stamp);
  /// True when the outbox was empty before.
  bool put(std::shared_ptr<const Content> content, std::int64_t stamp, std::int64_t now);
  void start_drain(bool was_empty);
  void hand_over(SubscriptionCore& subscription, const OutgoingMessage& message) const;
  void make_room(std::size_t bytes);

  const std::shared_ptr<NodeLink> link_;
  const TopicHead head_;
  const QoS qos_;
  const std::shared_ptr<const Schema> schema_;
  const std::uint64_t id_;
  const SharedName topic_name_, sender_name_;

  mutable std::mutex mutex_;
  mutable std::condition_variable changed_;
  std::function<void()> drain_;
  std::deque<OutgoingMessage> outbox_;
  std::size_t outbox_bytes_ = 0;
  std::vector<std::shared_ptr<SubscriptionCore>> local_;
  bool keeps_ = true;
  bool slab_readers_ = false;
  std::uint64_t last_sequence_ = 0;
  PublisherStatistics statistics_;
  std::chrono::steady_clock::time_point last_drain_;
  bool stopped_ = false;
};

}  // namespace prehend::graph
