#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "prehend/graph/qos.h"
#include "prehend/graph/schema.h"

namespace google::protobuf {
class Message;
}

namespace prehend::graph {

class SubscriptionCore;
struct MessageFrames;

/// Where a message comes from.
struct MessageInfo {
  std::string topic;              ///< after remapping
  std::uint64_t sequence = 0;     ///< of its publisher on this topic, from 1
  std::int64_t stamp = 0;         ///< ns: the content's time (header.stamp), else when published
  std::int64_t publish_time = 0;  ///< ns: publisher's clock
  std::string sender;             ///< publishing node's name
  std::uint64_t schema_hash = 0;
};

/// A received message and where it comes from. Cheap to copy; copies share the message.
template <class Message>
class Received {
 public:
  Received(std::shared_ptr<const Message> message, std::shared_ptr<const MessageInfo> info)
      : message_(std::move(message)), info_(std::move(info)) {}

  const Message& operator*() const { return *message_; }
  const Message* operator->() const { return message_.get(); }
  const MessageInfo& info() const { return *info_; }
  /// Keeps the message alive beyond the callback without copying it.
  std::shared_ptr<const Message> shared() const { return message_; }

 private:
  std::shared_ptr<const Message> message_;
  std::shared_ptr<const MessageInfo> info_;
};

/// A message not decoded, as subscribe_raw delivers it.
struct RawMessage {
  MessageInfo info;
  std::string bytes;                     ///< standard protobuf encoding
  std::shared_ptr<const Schema> schema;  ///< with descriptor set
};

/// What became of the messages to a subscription.
struct SubscriptionStatistics {
  std::uint64_t received = 0;            ///< that came over the wire, valid
  std::uint64_t delivered = 0;           ///< handed to the callback
  std::uint64_t dropped = 0;             ///< thrown away, oldest first, as the queue was full
  std::uint64_t superseded = 0;          ///< overwritten by a newer one, with QoS::latest
  std::uint64_t missed = 0;              ///< never came: gaps in publishers' sequence numbers
  std::uint64_t malformed = 0;           ///< frames or encoding damaged
  std::uint64_t refused_publishers = 0;  ///< publishers whose message type differs
  std::size_t publishers = 0;            ///< joined now
};

/// Holds a subscription: destroying it ends the subscription. After the destructor no callback runs
/// any more; it waits for one that runs in another thread.
class Subscription {
 public:
  Subscription() = default;
  explicit Subscription(std::shared_ptr<SubscriptionCore> core);
  ~Subscription();
  Subscription(Subscription&&) noexcept;
  Subscription& operator=(Subscription&&) noexcept;

  SubscriptionStatistics statistics() const;
  /// Name after remapping.
  const std::string& topic() const;

 private:
  std::shared_ptr<SubscriptionCore> core_;
};

/// Decodes a message from its frames. False when they do not hold such a message.
bool decode(const MessageFrames& frames, google::protobuf::Message& message);

}  // namespace prehend::graph
