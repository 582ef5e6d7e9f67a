#include "prehend/graph/link/frames.h"

#include <unistd.h>

#include <bit>
#include <cerrno>
#include <cstring>

namespace prehend::graph {
namespace {

static_assert(std::endian::native == std::endian::little, "batches are little-endian");

constexpr std::size_t kLargestInBatch = 4096;
constexpr std::size_t kRecordHeadBytes = 8 + 8 + 4;

zmq::message_t envelope_frame(const TopicHead& head, const OutgoingMessage& message,
                              const EncodedMessage* in_slab) {
  msgs::graph::Envelope envelope;
  envelope.set_sequence(message.sequence);
  envelope.set_stamp(message.stamp);
  envelope.set_publish_time(message.publish_time);
  envelope.set_sender(head.sender);
  envelope.set_schema_hash(head.schema_hash);
  if (in_slab) {
    const Slab& slab = *in_slab->slab;
    const SharedBytes& part = in_slab->body_in_slab ? in_slab->body : in_slab->payload;
    auto& content = *envelope.mutable_slab();
    content.set_part(in_slab->body_in_slab ? msgs::graph::SlabContent::BODY
                                           : msgs::graph::SlabContent::PAYLOAD);
    content.set_pid(::getpid());
    content.set_file(slab.file());
    content.set_id(slab.id());
    content.set_generation(slab.generation());
    content.set_offset(static_cast<std::uint64_t>(part.data() - slab.data()));
    content.set_size(part.size());
  }
  zmq::message_t frame(envelope.ByteSizeLong());
  envelope.SerializeWithCachedSizesToArray(static_cast<std::uint8_t*>(frame.data()));
  return frame;
}

template <class Number>
void put(char*& at, Number value) {
  std::memcpy(at, &value, sizeof value);
  at += sizeof value;
}

template <class Number>
Number get(const std::uint8_t*& at) {
  Number value;
  std::memcpy(&value, at, sizeof value);
  at += sizeof value;
  return value;
}

}  // namespace

Frames receive(zmq::socket_ref socket) {
  Frames frames;
  while (true) {
    zmq::message_t frame;
    // Only the first frame can be missing: ZeroMQ delivers messages whole.
    if (!socket.recv(frame, zmq::recv_flags::dontwait)) return frames;
    const bool more = frame.more();
    if (frames.size() <= kMaxFrames) frames.push_back(std::move(frame));
    if (!more) return frames;
  }
}

Frames to_wire(const TopicHead& head, const OutgoingMessage& message, std::uint32_t slab_reader) {
  const EncodedMessage& encoded = message.content->encoded();
  const bool in_slab = slab_reader != 0 && encoded.slab;
  Frames wire(5);
  wire[0] = zmq::message_t(head.topic);
  wire[1] = envelope_frame(head, message, in_slab ? &encoded : nullptr);
  if (!in_slab || !encoded.body_in_slab) wire[2] = encoded.body.to_frame();
  wire[3] = encoded.prefix.to_frame();
  if (!in_slab || encoded.body_in_slab) wire[4] = encoded.payload.to_frame();
  return wire;
}

bool fits_in_batch(const OutgoingMessage& message) {
  return message.content->bytes() <= kLargestInBatch && message.content->encoded().payload.empty();
}

Frames to_wire(const TopicHead& head, std::span<const OutgoingMessage> batch) {
  std::size_t size = 0;
  for (const OutgoingMessage& message : batch) {
    size += kRecordHeadBytes + message.content->encoded().body.size();
  }
  Frames wire(3);
  wire[0] = zmq::message_t(head.topic);
  wire[1] = envelope_frame(head, batch.front(), nullptr);
  wire[2] = zmq::message_t(size);
  char* at = static_cast<char*>(wire[2].data());
  for (const OutgoingMessage& message : batch) {
    const SharedBytes& body = message.content->encoded().body;
    put(at, message.stamp);
    put(at, message.publish_time);
    put(at, static_cast<std::uint32_t>(body.size()));
    if (!body.empty()) std::memcpy(at, body.data(), body.size());
    at += body.size();
  }
  return wire;
}

bool read_batch(const SharedBytes& batch, const std::function<void(BatchRecord)>& take) {
  const std::uint8_t* at = batch.data();
  const std::uint8_t* const end = at + batch.size();
  while (at != end) {
    if (static_cast<std::size_t>(end - at) < kRecordHeadBytes) return false;
    BatchRecord record;
    record.stamp = get<std::int64_t>(at);
    record.publish_time = get<std::int64_t>(at);
    const auto size = get<std::uint32_t>(at);
    if (static_cast<std::size_t>(end - at) < size) return false;
    record.encoded = batch.slice(static_cast<std::size_t>(at - batch.data()), size);
    at += size;
    take(std::move(record));
  }
  return true;
}

Frames to_wire(const msgs::graph::PeerMessage& message) {
  Frames wire(2);
  wire[1] = zmq::message_t(message.SerializeAsString());
  return wire;
}

SendResult send(zmq::socket_ref socket, const std::string& route, Frames& frames) {
  const auto flags = [&](std::size_t i) {
    return i + 1 < frames.size() ? zmq::send_flags::dontwait | zmq::send_flags::sndmore
                                 : zmq::send_flags::dontwait;
  };
  try {
    if (!route.empty() &&
        !socket.send(zmq::buffer(route), zmq::send_flags::dontwait | zmq::send_flags::sndmore)) {
      return SendResult::kFull;
    }
    for (std::size_t i = 0; i < frames.size(); ++i) {
      if (!socket.send(frames[i], flags(i))) return SendResult::kFull;
    }
  } catch (const zmq::error_t& error) {
    if (error.num() == EHOSTUNREACH) return SendResult::kNoRoute;
    throw;
  }
  return SendResult::kSent;
}

}  // namespace prehend::graph
