#include "prehend/graph/link/frames.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/io/zero_copy_stream_impl.h>
#include <google/protobuf/io/zero_copy_stream_impl_lite.h>
#include <google/protobuf/message.h>
#include <google/protobuf/wire_format_lite.h>

#include <array>
#include <memory>
#include <stdexcept>

#include "prehend/graph/subscription.h"

namespace prehend::graph {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr int kPayloadField = 15;

// Frames larger than this share memory with their source; smaller ones are cheaper to copy.
constexpr std::size_t kSharingPays = 1024;

const FieldDescriptor* payload_field(const Message& message) {
  const FieldDescriptor* field = message.GetDescriptor()->FindFieldByNumber(kPayloadField);
  const bool fits = field && field->type() == FieldDescriptor::TYPE_BYTES && !field->is_repeated();
  return fits ? field : nullptr;
}

// The payload can be split off the end of the encoding only if nothing is encoded behind it.
bool is_last(const Message& message, const FieldDescriptor& field) {
  for (int i = 0; i < message.GetDescriptor()->field_count(); ++i) {
    if (message.GetDescriptor()->field(i)->number() > field.number()) return false;
  }
  return message.GetReflection()->GetUnknownFields(message).empty();
}

void check_size(std::size_t bytes, const std::string& type) {
  if (bytes > static_cast<std::size_t>(kMaxFrameBytes)) {
    throw std::length_error(type + " of " + std::to_string(bytes) +
                            " bytes is larger than a message may be (" +
                            std::to_string(kMaxFrameBytes) + ")");
  }
}

// A frame that views `bytes` and keeps `owner` alive.
template <class Owner>
zmq::message_t view_of(const void* bytes, std::size_t size, std::shared_ptr<Owner> owner) {
  if (size < kSharingPays) return zmq::message_t(bytes, size);
  auto* kept = new std::shared_ptr<Owner>(std::move(owner));
  return zmq::message_t(
      const_cast<void*>(bytes), size,
      [](void*, void* hint) { delete static_cast<std::shared_ptr<Owner>*>(hint); }, kept);
}

zmq::message_t payload_prefix(std::size_t payload_bytes) {
  using google::protobuf::internal::WireFormatLite;
  using google::protobuf::io::CodedOutputStream;
  std::array<std::uint8_t, 16> buffer{};
  std::uint8_t* end = CodedOutputStream::WriteTagToArray(
      WireFormatLite::MakeTag(kPayloadField, WireFormatLite::WIRETYPE_LENGTH_DELIMITED),
      buffer.data());
  end = CodedOutputStream::WriteVarint32ToArray(static_cast<std::uint32_t>(payload_bytes), end);
  return zmq::message_t(buffer.data(), static_cast<std::size_t>(end - buffer.data()));
}

template <class Owner>
MessageFrames with_payload(const Message& message, const void* data, std::size_t size,
                           std::shared_ptr<Owner> owner) {
  check_size(size, message.GetTypeName());
  MessageFrames frames = encode(message);
  frames.prefix = payload_prefix(size);
  frames.payload = view_of(data, size, std::move(owner));
  return frames;
}

}  // namespace

MessageFrames MessageFrames::share() {
  MessageFrames other;
  other.body.copy(body);
  other.prefix.copy(prefix);
  other.payload.copy(payload);
  return other;
}

std::string MessageFrames::concatenated() const {
  std::string bytes;
  bytes.reserve(this->bytes());
  bytes.append(static_cast<const char*>(body.data()), body.size());
  bytes.append(static_cast<const char*>(prefix.data()), prefix.size());
  bytes.append(static_cast<const char*>(payload.data()), payload.size());
  return bytes;
}

MessageFrames encode(const Message& message) {
  const std::size_t size = message.ByteSizeLong();
  check_size(size, message.GetTypeName());
  std::shared_ptr<std::uint8_t[]> bytes(new std::uint8_t[size]);
  message.SerializeWithCachedSizesToArray(bytes.get());
  MessageFrames frames;
  const FieldDescriptor* field = payload_field(message);
  std::string scratch;
  const std::size_t payload =
      field ? message.GetReflection()->GetStringReference(message, field, &scratch).size() : 0;
  if (payload == 0 || !is_last(message, *field)) {
    frames.body = view_of(bytes.get(), size, bytes);
    return frames;
  }
  frames.prefix = payload_prefix(payload);
  const std::size_t body = size - payload - frames.prefix.size();
  frames.body = view_of(bytes.get(), body, bytes);
  frames.payload = view_of(bytes.get() + size - payload, payload, bytes);
  return frames;
}

MessageFrames encode_moving(Message& message) {
  const FieldDescriptor* field = payload_field(message);
  if (!field || message.GetArena() != nullptr) return encode(message);
  std::string scratch;
  const std::string& content =
      message.GetReflection()->GetStringReference(message, field, &scratch);
  if (content.size() < kSharingPays || &content == &scratch) return encode(message);
  // The message is ours to take apart: its non-empty string field is a string object of its own.
  auto payload = std::make_shared<std::string>(std::move(const_cast<std::string&>(content)));
  message.GetReflection()->ClearField(&message, field);
  return with_payload(message, payload->data(), payload->size(), payload);
}

MessageFrames encode_with_payload(const Message& message, std::vector<std::uint8_t>&& payload) {
  const FieldDescriptor* field = payload_field(message);
  if (!field) {
    throw std::invalid_argument(message.GetTypeName() + " has no payload: no bytes field 15");
  }
  if (message.GetReflection()->HasField(message, field)) {
    throw std::invalid_argument(message.GetTypeName() + ": field '" + field->name() +
                                "' is set and a payload is given apart; use one of both");
  }
  if (payload.empty()) return encode(message);
  auto kept = std::make_shared<std::vector<std::uint8_t>>(std::move(payload));
  return with_payload(message, kept->data(), kept->size(), kept);
}

MessageFrames encode_raw(std::string bytes) {
  check_size(bytes.size(), "a message");
  auto kept = std::make_shared<std::string>(std::move(bytes));
  MessageFrames frames;
  frames.body = view_of(kept->data(), kept->size(), kept);
  return frames;
}

std::int64_t header_stamp(const Message& message) {
  const FieldDescriptor* header = message.GetDescriptor()->FindFieldByName("header");
  if (!header || header->is_repeated() || !header->message_type()) return 0;
  const FieldDescriptor* stamp = header->message_type()->FindFieldByName("stamp");
  if (!stamp || stamp->is_repeated() || stamp->type() != FieldDescriptor::TYPE_INT64) return 0;
  const Message& content = message.GetReflection()->GetMessage(message, header);
  return content.GetReflection()->GetInt64(content, stamp);
}

bool decode(const MessageFrames& frames, Message& message) {
  using google::protobuf::io::ArrayInputStream;
  ArrayInputStream body(frames.body.data(), static_cast<int>(frames.body.size()));
  if (frames.prefix.size() == 0 && frames.payload.size() == 0) {
    return message.ParseFromZeroCopyStream(&body);
  }
  ArrayInputStream prefix(frames.prefix.data(), static_cast<int>(frames.prefix.size()));
  ArrayInputStream payload(frames.payload.data(), static_cast<int>(frames.payload.size()));
  std::array<google::protobuf::io::ZeroCopyInputStream*, 3> parts{&body, &prefix, &payload};
  google::protobuf::io::ConcatenatingInputStream all(parts.data(), 3);
  return message.ParseFromZeroCopyStream(&all);
}

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

Frames to_wire(const std::string& topic, TopicFrames& frames) {
  Frames wire(5);
  wire[0] = zmq::message_t(topic);
  wire[1] = zmq::message_t(frames.envelope);
  MessageFrames content = frames.message.share();
  wire[2] = std::move(content.body);
  wire[3] = std::move(content.prefix);
  wire[4] = std::move(content.payload);
  return wire;
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
