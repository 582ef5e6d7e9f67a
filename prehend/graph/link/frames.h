#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include <zmq.hpp>

#include "msgs/graph.pb.h"
#include "prehend/graph/link/content.h"

namespace prehend::graph {

/// A published message on its way to its readers.
struct OutgoingMessage {
  std::shared_ptr<const Content> content;
  std::uint64_t sequence = 0;
  std::int64_t stamp = 0;         ///< ns
  std::int64_t publish_time = 0;  ///< ns
};

/// What all messages of a publisher have in common.
struct TopicHead {
  std::string topic;
  std::string sender;
  std::uint64_t schema_hash = 0;
};

/// A multipart message in full.
using Frames = std::vector<zmq::message_t>;

/// Receives all frames of one message without waiting; empty when there is none. Frames beyond
/// `kMaxFrames` are thrown away, and the result then has kMaxFrames + 1 frames: malformed.
inline constexpr std::size_t kMaxFrames = 8;
Frames receive(zmq::socket_ref socket);

/// The frames `topic | Envelope | body | prefix | payload`. With a `slab_reader` (not 0) what lies
/// in shared memory stays there: its frame is empty and the envelope says where it is.
Frames to_wire(const TopicHead& head, const OutgoingMessage& message, std::uint32_t slab_reader);

/// Small messages that follow each other travel together, at most this many bytes.
inline constexpr std::size_t kMaxBatchBytes = std::size_t{64} << 10;
/// Whether a message may travel with others.
bool fits_in_batch(const OutgoingMessage& message);
/// The frames `topic | Envelope | batch`: the envelope is the first message's, the batch one record
/// for each: stamp, publish time (int64), length of the encoding (uint32), all little-endian, and
/// the encoding. Sequence numbers follow the first.
Frames to_wire(const TopicHead& head, std::span<const OutgoingMessage> batch);

/// Takes a batch apart. False, and no or some calls, when it is damaged.
struct BatchRecord {
  std::int64_t stamp = 0;
  std::int64_t publish_time = 0;
  SharedBytes encoded;
};
bool read_batch(const SharedBytes& batch, const std::function<void(BatchRecord)>& take);

/// The frames `"" | PeerMessage`.
Frames to_wire(const msgs::graph::PeerMessage& message);

enum class SendResult { kSent, kFull, kNoRoute };
/// Sends all frames, after `route` when not empty, without waiting. `frames` stay valid unless
/// sent.
SendResult send(zmq::socket_ref socket, const std::string& route, Frames& frames);

}  // namespace prehend::graph
