#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "prehend/graph/qos.h"

namespace google::protobuf {
class Message;
}

namespace prehend::graph {

class PublisherCore;
class Slab;
struct Schema;

/// What became of a publisher's messages.
struct PublisherStatistics {
  std::uint64_t published = 0;         ///< calls of publish
  std::uint64_t dropped = 0;           ///< messages a slow reader never got, summed over readers
  std::uint64_t superseded = 0;        ///< the same with QoS::latest, where it is meant to be
  std::uint64_t bytes = 0;             ///< of the messages published
  std::uint64_t queue_high_water = 0;  ///< most messages that ever waited for one slow reader
  std::uint64_t queue_high_water_bytes = 0;
  std::size_t subscribers = 0;  ///< that have joined
  std::size_t slab_bytes = 0;   ///< shared memory that the node holds now
};

/// Memory for a payload, to be filled in place: shared memory where subscribers of other processes
/// on this host can see it, else the heap. From Publisher::loan.
class LoanedPayload {
 public:
  LoanedPayload() = default;
  /// To be filled by the caller; not initialised. Empty when it was published or moved from.
  std::span<std::uint8_t> bytes() const { return bytes_; }

 private:
  friend class PublisherBase;
  std::span<std::uint8_t> bytes_;
  std::shared_ptr<const void> owner_;
  std::shared_ptr<Slab> slab_;  // null: on the heap
};

/// What all publishers share. Cheap to copy; copies are the same publisher, and the topic is
/// withdrawn when the last copy goes. All functions may be called from any thread.
class PublisherBase {
 public:
  /// Waits until at least `count` subscribers have joined: what is published from then on reaches
  /// them. `timeout` is wall time. False when it ran out or the node was shut down. Throws
  /// std::logic_error inside one of the node's callbacks, unless the timeout is 0.
  bool wait_for_subscribers(std::size_t count, std::chrono::nanoseconds timeout) const;
  std::size_t subscriber_count() const;
  PublisherStatistics statistics() const;
  /// Name after remapping.
  const std::string& topic() const;
  explicit operator bool() const { return core_ != nullptr; }

  /// Memory for a payload of `bytes`, to be filled and published without any copy. Throws
  /// std::length_error for more than a message may have (256 MiB).
  LoanedPayload loan(std::size_t bytes) const;

 protected:
  PublisherBase() = default;
  explicit PublisherBase(std::shared_ptr<PublisherCore> core) : core_(std::move(core)) {}
  void publish_copy(const google::protobuf::Message& message) const;
  void publish_moved(google::protobuf::Message& message) const;
  void publish_payload(google::protobuf::Message& message,
                       std::vector<std::uint8_t>&& payload) const;
  void publish_loaned(google::protobuf::Message& message, LoanedPayload&& payload) const;
  void publish_shared(std::shared_ptr<const google::protobuf::Message> message) const;
  void publish_each(std::span<const google::protobuf::Message* const> messages) const;
  void publish_encoded(std::string bytes, std::int64_t stamp) const;

  std::shared_ptr<PublisherCore> core_;
};

/// Publishes `Message` (a generated protobuf type) on one topic. No call of publish waits for a
/// reader or the network; ordering is kept. A call on an empty publisher throws std::logic_error.
template <class Message>
class Publisher : public PublisherBase {
 public:
  Publisher() = default;
  explicit Publisher(std::shared_ptr<PublisherCore> core) : PublisherBase(std::move(core)) {}

  /// Copies the message once, in the calling thread.
  void publish(const Message& message) const { publish_copy(message); }

  /// Takes the message. Subscribers in this process get it without any copy; others get the payload
  /// (the top-level `bytes` field number 15) copied once into shared memory, or sent as it is.
  void publish(Message&& message) const { publish_moved(message); }

  /// Shares the message, which must not change any more, with subscribers in this process.
  void publish(std::shared_ptr<const Message> message) const { publish_shared(std::move(message)); }

  /// Publishes many at once, in order: one lock, and small ones travel together.
  void publish_all(std::span<const Message> messages) const {
    std::vector<const google::protobuf::Message*> pointers;
    pointers.reserve(messages.size());
    for (const Message& message : messages) pointers.push_back(&message);
    publish_each(pointers);
  }

  /// The payload lies in loaned memory and is not copied at all; `message`'s own payload field must
  /// be empty. Throws std::invalid_argument when the type has no payload field or it is not empty.
  void publish(Message message, LoanedPayload&& payload) const {
    publish_loaned(message, std::move(payload));
  }

  /// The payload comes apart and is not copied; `message`'s own payload field must be empty.
  /// Throws std::invalid_argument when the type has no payload field or it is not empty.
  void publish(Message message, std::vector<std::uint8_t>&& payload) const {
    publish_payload(message, std::move(payload));
  }
};

/// Publishes messages that are already encoded, of any type: for replay and bridges.
class RawPublisher : public PublisherBase {
 public:
  RawPublisher() = default;
  explicit RawPublisher(std::shared_ptr<PublisherCore> core) : PublisherBase(std::move(core)) {}

  /// `bytes`: one message in standard protobuf encoding, of the schema given to advertise_raw (not
  /// checked). `stamp` [ns] goes into the envelope as it is.
  void publish(std::string bytes, std::int64_t stamp) const {
    publish_encoded(std::move(bytes), stamp);
  }
};

}  // namespace prehend::graph
