#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include <zmq.hpp>

#include "msgs/graph.pb.h"

namespace prehend::graph {

/// Largest frame a socket takes. ZeroMQ closes the connection of a peer that announces more, before
/// it allocates memory.
inline constexpr std::int64_t kMaxFrameBytes = std::int64_t{256} << 20;

/// The content of a published message: body + prefix + payload is its standard encoding.
struct MessageFrames {
  zmq::message_t body;
  zmq::message_t prefix;   ///< tag and length of the payload field, or empty
  zmq::message_t payload;  ///< content of the payload field, or empty

  std::size_t bytes() const { return body.size() + prefix.size() + payload.size(); }
  /// Shares the memory.
  MessageFrames share();
  std::string concatenated() const;
};

/// A message with its envelope, ready to be sent to any number of readers.
struct TopicFrames {
  std::string envelope;
  MessageFrames message;
  std::uint64_t sequence = 0;

  TopicFrames share() { return {envelope, message.share(), sequence}; }
};

/// A multipart message in full.
using Frames = std::vector<zmq::message_t>;

/// Encodes `message`, copying it once. Throws std::length_error above kMaxFrameBytes.
MessageFrames encode(const google::protobuf::Message& message);
/// The same, taking the payload field's content out of `message` without a copy.
MessageFrames encode_moving(google::protobuf::Message& message);
/// The same with the payload apart; see Publisher::publish.
MessageFrames encode_with_payload(const google::protobuf::Message& message,
                                  std::vector<std::uint8_t>&& payload);
/// Takes bytes that are encoded already.
MessageFrames encode_raw(std::string bytes);

/// `header.stamp` of the message, 0 when it has none.
std::int64_t header_stamp(const google::protobuf::Message& message);

/// Receives all frames of one message without waiting; empty when there is none. Frames beyond
/// `kMaxFrames` are thrown away, and the result then has kMaxFrames + 1 frames: malformed.
inline constexpr std::size_t kMaxFrames = 8;
Frames receive(zmq::socket_ref socket);

/// The frames `topic | Envelope | body | prefix | payload`.
Frames to_wire(const std::string& topic, TopicFrames& frames);
/// The frames `"" | PeerMessage`.
Frames to_wire(const msgs::graph::PeerMessage& message);

enum class SendResult { kSent, kFull, kNoRoute };
/// Sends all frames, after `route` when not empty, without waiting. `frames` stay valid unless
/// sent.
SendResult send(zmq::socket_ref socket, const std::string& route, Frames& frames);

}  // namespace prehend::graph
