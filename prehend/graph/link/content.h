#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "prehend/graph/link/batch_memory.h"
#include "prehend/graph/link/shared_bytes.h"
#include "prehend/graph/link/slab.h"
#include "prehend/graph/subscription.h"

namespace google::protobuf {
class Message;
}

namespace prehend::graph {

/// Largest frame a socket takes. ZeroMQ closes the connection of a peer that announces more, before
/// it allocates memory.
inline constexpr std::int64_t kMaxFrameBytes = std::int64_t{256} << 20;

/// Parts of at least this size go into shared memory: below it, opening and leasing cost more than
/// copying [bytes].
inline constexpr std::size_t kSlabPays = std::size_t{32} << 10;

/// An encoded message: body + prefix + payload is its standard protobuf encoding.
struct EncodedMessage {
  SharedBytes body;
  SharedBytes prefix;   ///< tag and length of the payload field, or empty
  SharedBytes payload;  ///< content of the payload field, or empty
  /// Not null: the payload, or the body if `body_in_slab`, lies in this shared memory.
  std::shared_ptr<Slab> slab;
  bool body_in_slab = false;

  std::size_t bytes() const { return body.size() + prefix.size() + payload.size(); }
  std::string concatenated() const;
};

/// Where encoding puts large parts: into shared memory of `pool`, or the heap if it is null or
/// full.
std::shared_ptr<Slab> large_part(const std::shared_ptr<SlabPool>& pool, std::size_t bytes);

/// Encodes `message`, copying it once. Throws std::length_error above kMaxFrameBytes. A small one
/// goes into `batch` if that is not null.
EncodedMessage encode(const google::protobuf::Message& message,
                      const std::shared_ptr<SlabPool>& pool = nullptr,
                      BatchMemory<std::uint8_t>* batch = nullptr);
/// The same with the payload apart, in `slab` if that is not null, else put there as by encode.
EncodedMessage encode_with_payload(const google::protobuf::Message& message, SharedBytes payload,
                                   std::shared_ptr<Slab> slab,
                                   const std::shared_ptr<SlabPool>& pool = nullptr);
/// Takes bytes that are encoded already.
EncodedMessage encode_raw(std::string bytes);

/// Whether prefix and payload belong together, as what comes from outside must show.
bool is_consistent(const EncodedMessage& message);

/// `header.stamp` of the message, 0 when it has none.
std::int64_t header_stamp(const google::protobuf::Message& message);

/// A published message: as an object of this process, encoded, or both. Thread-safe.
class Content {
 public:
  explicit Content(EncodedMessage encoded);
  /// Encoded when first asked for, large parts into `pool`. `payload`: of a message whose payload
  /// field is empty, else empty itself; it lies in `slab` if that is not null.
  Content(std::shared_ptr<const google::protobuf::Message> object, SharedBytes payload,
          std::shared_ptr<Slab> slab, std::shared_ptr<SlabPool> pool);

  const EncodedMessage& encoded() const;
  /// Null when it came encoded.
  const std::shared_ptr<const google::protobuf::Message>& object() const { return object_; }
  /// That is not in object().
  const SharedBytes& payload_apart() const { return payload_; }
  std::size_t bytes() const { return bytes_; }

 private:
  const std::shared_ptr<const google::protobuf::Message> object_;
  const SharedBytes payload_;
  std::size_t bytes_ = 0;
  mutable std::shared_ptr<Slab> slab_;
  mutable std::shared_ptr<SlabPool> pool_;
  mutable std::mutex encoding_;
  mutable std::atomic<bool> is_encoded_ = false;
  mutable EncodedMessage encoded_;
};

/// Takes the payload field's content out of `message` without a copy; empty when it has none, or
/// one too small to be worth it.
SharedBytes take_payload(google::protobuf::Message& message);

/// Throws std::invalid_argument unless the type has a payload field and `message`'s is empty.
void check_payload_comes_apart(const google::protobuf::Message& message);

}  // namespace prehend::graph
