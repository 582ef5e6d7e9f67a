#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "prehend/graph/qos.h"

namespace google::protobuf {
class Message;
}

namespace prehend::graph {

class PublisherCore;
struct Schema;

/// What became of a publisher's messages.
struct PublisherStatistics {
  std::uint64_t published = 0;   ///< calls of publish
  std::uint64_t dropped = 0;     ///< messages a slow reader never got, summed over readers
  std::uint64_t superseded = 0;  ///< the same with QoS::latest, where it is meant to be
  std::size_t subscribers = 0;   ///< that have joined
};

/// What all publishers share. Cheap to copy; copies are the same publisher, and the topic is
/// withdrawn when the last copy goes. All functions may be called from any thread.
class PublisherBase {
 public:
  /// Waits until at least `count` subscribers have joined: what is published from then on reaches
  /// them. `timeout` is wall time. False when it ran out or the node was shut down.
  bool wait_for_subscribers(std::size_t count, std::chrono::nanoseconds timeout) const;
  std::size_t subscriber_count() const;
  PublisherStatistics statistics() const;
  /// Name after remapping.
  const std::string& topic() const;
  explicit operator bool() const { return core_ != nullptr; }

 protected:
  PublisherBase() = default;
  explicit PublisherBase(std::shared_ptr<PublisherCore> core) : core_(std::move(core)) {}
  void publish_copy(const google::protobuf::Message& message) const;
  void publish_moved(google::protobuf::Message& message) const;
  void publish_payload(google::protobuf::Message& message,
                       std::vector<std::uint8_t>&& payload) const;
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

  /// Encodes the message in the calling thread: copies it once.
  void publish(const Message& message) const { publish_copy(message); }

  /// As above, but takes the message's payload (its top-level `bytes` field number 15) without
  /// copying it.
  void publish(Message&& message) const { publish_moved(message); }

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
