#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <mutex>
#include <ostream>
#include <span>
#include <string>
#include <utility>

#include "prehend/graph/qos.h"
#include "prehend/graph/schema.h"

namespace google::protobuf {
class Message;
}

namespace prehend::graph {

class SubscriptionCore;
class Content;

/// A name that many messages share: reads as a std::string, copies as a pointer.
class SharedName {
 public:
  SharedName() : SharedName(std::string()) {}
  SharedName(std::string name) : name_(std::make_shared<const std::string>(std::move(name))) {}
  operator const std::string&() const { return *name_; }
  const std::string& str() const { return *name_; }
  const char* c_str() const { return name_->c_str(); }
  friend bool operator==(const SharedName& a, const std::string& b) { return *a.name_ == b; }
  friend std::ostream& operator<<(std::ostream& out, const SharedName& a) {
    return out << *a.name_;
  }

 private:
  std::shared_ptr<const std::string> name_;
};

/// Where a message comes from.
struct MessageInfo {
  SharedName topic;               ///< after remapping
  std::uint64_t sequence = 0;     ///< of its publisher on this topic, from 1
  std::int64_t stamp = 0;         ///< ns: the content's time (header.stamp), else when published
  std::int64_t publish_time = 0;  ///< ns: publisher's clock
  SharedName sender;              ///< publishing node's name
  std::uint64_t schema_hash = 0;
};

/// What a Received is made of.
struct MessageParts {
  std::shared_ptr<const google::protobuf::Message> body;
  std::span<const std::uint8_t> payload;
  std::shared_ptr<const void> payload_owner;
  bool payload_is_apart = false;  ///< not in the body
};

/// Takes a message apart, decoding it as another one of the type of `prototype` unless it is such
/// an object already. False when it is damaged.
bool take_parts(const Content& content, const google::protobuf::Message& prototype,
                MessageParts& parts);
/// Fills the payload field (`bytes`, number 15).
void set_payload(google::protobuf::Message& message, std::span<const std::uint8_t> payload);

/// A received message and where it comes from. Cheap to copy; copies share the message. It may lie
/// in the publisher's memory (a node of this process), in shared memory (a process of this host) or
/// in a frame; it stays valid as long as a copy lives, also when the publisher has gone.
template <class Message>
class Received {
 public:
  Received(MessageParts parts, std::shared_ptr<const MessageInfo> info)
      : state_(std::make_shared<State>(std::move(parts), std::move(info))) {}

  /// The whole message. A large payload is copied into it when this is first asked for; body() and
  /// payload() cost nothing.
  const Message& operator*() const { return *whole(); }
  const Message* operator->() const { return whole(); }
  /// The whole message, kept alive beyond the callback.
  std::shared_ptr<const Message> shared() const {
    return std::shared_ptr<const Message>(state_, whole());
  }

  /// The message, its payload field (`bytes`, number 15) perhaps left empty.
  const Message& body() const { return static_cast<const Message&>(*state_->parts.body); }
  /// The payload field's content; empty for types that have none. Valid as long as a copy of this.
  std::span<const std::uint8_t> payload() const { return state_->parts.payload; }

  const MessageInfo& info() const { return *state_->info; }

 private:
  struct State {
    State(MessageParts p, std::shared_ptr<const MessageInfo> i)
        : parts(std::move(p)), info(std::move(i)) {}
    MessageParts parts;
    std::shared_ptr<const MessageInfo> info;
    std::once_flag once;
    std::unique_ptr<Message> completed;
  };

  const Message* whole() const {
    if (!state_->parts.payload_is_apart) return &body();
    std::call_once(state_->once, [this] {
      auto message = std::make_unique<Message>(body());
      set_payload(*message, payload());
      state_->completed = std::move(message);
    });
    return state_->completed.get();
  }

  std::shared_ptr<State> state_;
};

/// A message not decoded, as subscribe_raw delivers it.
struct RawMessage {
  MessageInfo info;
  std::string bytes;                     ///< standard protobuf encoding
  std::shared_ptr<const Schema> schema;  ///< with descriptor set
};

/// What became of the messages to a subscription.
struct SubscriptionStatistics {
  std::uint64_t received = 0;            ///< that came, valid
  std::uint64_t delivered = 0;           ///< handed to the callback
  std::uint64_t dropped = 0;             ///< thrown away, oldest first, as the queue was full
  std::uint64_t superseded = 0;          ///< overwritten by a newer one, with QoS::latest
  std::uint64_t missed = 0;              ///< never came: gaps in publishers' sequence numbers
  std::uint64_t malformed = 0;           ///< frames or encoding damaged
  std::uint64_t refused_publishers = 0;  ///< publishers whose message type differs
  std::uint64_t bytes = 0;               ///< of the messages received
  std::uint64_t queue_high_water = 0;    ///< most messages that ever waited for the callback
  std::uint64_t queue_high_water_bytes = 0;
  std::size_t publishers = 0;  ///< joined now
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

}  // namespace prehend::graph
