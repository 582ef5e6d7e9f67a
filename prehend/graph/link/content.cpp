#include "prehend/graph/link/content.h"

#include <google/protobuf/descriptor.h>
#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/message.h>
#include <google/protobuf/wire_format_lite.h>

#include <array>
#include <cstring>
#include <new>
#include <stdexcept>
#include <typeinfo>

namespace prehend::graph {
namespace {

using google::protobuf::FieldDescriptor;
using google::protobuf::Message;

constexpr int kPayloadField = 15;

// Payloads below this are not worth being taken apart from the message.
constexpr std::size_t kApartPays = 1024;

// Of payloads, for vector instructions.
constexpr std::size_t kAlignment = 64;

// What matters here of a message type.
struct Layout {
  const FieldDescriptor* payload = nullptr;  // bytes field 15
  bool payload_is_last = true;               // no declared field has a higher number
  const FieldDescriptor* header = nullptr;   // with a stamp
  const FieldDescriptor* stamp = nullptr;    // int64, in the header
};

Layout look_at(const google::protobuf::Descriptor& type) {
  Layout layout;
  const FieldDescriptor* payload = type.FindFieldByNumber(kPayloadField);
  if (payload && payload->type() == FieldDescriptor::TYPE_BYTES && !payload->is_repeated()) {
    layout.payload = payload;
  }
  for (int i = 0; i < type.field_count(); ++i) {
    layout.payload_is_last = layout.payload_is_last && type.field(i)->number() <= kPayloadField;
  }
  const FieldDescriptor* header = type.FindFieldByName("header");
  if (!header || header->is_repeated() || !header->message_type()) return layout;
  const FieldDescriptor* stamp = header->message_type()->FindFieldByName("stamp");
  if (!stamp || stamp->is_repeated() || stamp->type() != FieldDescriptor::TYPE_INT64) return layout;
  layout.header = header;
  layout.stamp = stamp;
  return layout;
}

// Generated types live as long as the process, so the last one seen can be remembered.
Layout layout_of(const Message& message) {
  using google::protobuf::Descriptor;
  const Descriptor* type = message.GetDescriptor();
  static thread_local const Descriptor* last_type = nullptr;
  static thread_local Layout last_layout;
  if (type == last_type) return last_layout;
  const Layout layout = look_at(*type);
  if (type->file()->pool() == google::protobuf::DescriptorPool::generated_pool()) {
    last_type = type;
    last_layout = layout;
  }
  return layout;
}

const FieldDescriptor* payload_field(const Message& message) { return layout_of(message).payload; }

// The message's own payload string; null when there is no such field.
const std::string* payload_of(const Message& message) {
  const FieldDescriptor* field = payload_field(message);
  if (!field) return nullptr;
  static thread_local std::string scratch;  // not used for generated or dynamic string fields
  return &message.GetReflection()->GetStringReference(message, field, &scratch);
}

// The payload can be split off the end of the encoding only if nothing is encoded behind it.
bool payload_is_last(const Message& message) {
  return layout_of(message).payload_is_last &&
         message.GetReflection()->GetUnknownFields(message).empty();
}

void check_size(std::size_t bytes, const std::string& type) {
  if (bytes > static_cast<std::size_t>(kMaxFrameBytes)) {
    throw std::length_error(type + " of " + std::to_string(bytes) +
                            " bytes is larger than a message may be (" +
                            std::to_string(kMaxFrameBytes) + ")");
  }
}

SharedBytes payload_prefix(std::size_t payload_bytes) {
  using google::protobuf::internal::WireFormatLite;
  using google::protobuf::io::CodedOutputStream;
  std::array<std::uint8_t, 16> buffer{};
  std::uint8_t* end = CodedOutputStream::WriteTagToArray(
      WireFormatLite::MakeTag(kPayloadField, WireFormatLite::WIRETYPE_LENGTH_DELIMITED),
      buffer.data());
  end = CodedOutputStream::WriteVarint32ToArray(static_cast<std::uint32_t>(payload_bytes), end);
  return SharedBytes::copy_of(buffer.data(), static_cast<std::size_t>(end - buffer.data()));
}

// Memory to be written, then shared.
struct Room {
  std::uint8_t* data;
  std::shared_ptr<const void> owner;
  std::shared_ptr<Slab> slab;
};

Room room_for(std::size_t bytes, const std::shared_ptr<SlabPool>& pool) {
  if (auto slab = large_part(pool, bytes)) return {slab->data(), slab, slab};
  std::shared_ptr<void> heap(::operator new(bytes, std::align_val_t(kAlignment)), [](void* memory) {
    ::operator delete(memory, std::align_val_t(kAlignment));
  });
  return {static_cast<std::uint8_t*>(heap.get()), heap, nullptr};
}

EncodedMessage encode_whole(const Message& message, std::size_t size,
                            const std::shared_ptr<SlabPool>& pool,
                            BatchMemory<std::uint8_t>* batch) {
  EncodedMessage encoded;
  if (size < kSlabPays && batch) {
    std::uint8_t* data = batch->allocate(size);
    message.SerializeWithCachedSizesToArray(data);
    encoded.body = SharedBytes(data, size, batch->resource());
    return encoded;
  }
  if (size < kSlabPays) {
    auto bytes = std::make_shared_for_overwrite<std::uint8_t[]>(size);
    std::uint8_t* data = bytes.get();
    message.SerializeWithCachedSizesToArray(data);
    encoded.body = SharedBytes(data, size, std::shared_ptr<const void>(std::move(bytes), data));
    return encoded;
  }
  Room room = room_for(size, pool);
  message.SerializeWithCachedSizesToArray(room.data);
  encoded.body = SharedBytes(room.data, size, std::move(room.owner));
  encoded.slab = std::move(room.slab);
  encoded.body_in_slab = encoded.slab != nullptr;
  return encoded;
}

}  // namespace

std::string EncodedMessage::concatenated() const {
  std::string bytes;
  bytes.reserve(this->bytes());
  for (const SharedBytes* part : {&body, &prefix, &payload}) {
    bytes.append(reinterpret_cast<const char*>(part->data()), part->size());
  }
  return bytes;
}

std::shared_ptr<Slab> large_part(const std::shared_ptr<SlabPool>& pool, std::size_t bytes) {
  return pool && bytes >= kSlabPays ? pool->acquire(bytes) : nullptr;
}

EncodedMessage encode(const Message& message, const std::shared_ptr<SlabPool>& pool,
                      BatchMemory<std::uint8_t>* batch) {
  const std::size_t size = message.ByteSizeLong();
  check_size(size, message.GetTypeName());
  const std::string* payload = payload_of(message);
  if (!payload || payload->size() < kApartPays || !payload_is_last(message)) {
    return encode_whole(message, size, pool, batch);
  }
  // One pass writes body, prefix and payload, so placed that the payload's numbers are aligned.
  EncodedMessage encoded;
  encoded.prefix = payload_prefix(payload->size());
  const std::size_t front = size - payload->size();
  const std::size_t padding = (kAlignment - front % kAlignment) % kAlignment;
  Room room = room_for(padding + size, pool);
  std::uint8_t* begin = room.data + padding;
  message.SerializeWithCachedSizesToArray(begin);
  encoded.body = SharedBytes::copy_of(begin, front - encoded.prefix.size());
  encoded.payload = SharedBytes(begin + front, payload->size(), std::move(room.owner));
  encoded.slab = std::move(room.slab);
  return encoded;
}

EncodedMessage encode_with_payload(const Message& message, SharedBytes payload,
                                   std::shared_ptr<Slab> slab,
                                   const std::shared_ptr<SlabPool>& pool) {
  const std::size_t size = message.ByteSizeLong();
  check_size(size + payload.size(), message.GetTypeName());
  EncodedMessage encoded = encode_whole(message, size, nullptr, nullptr);
  if (payload.empty()) return encoded;
  if (!slab && (slab = large_part(pool, payload.size()))) {
    std::memcpy(slab->data(), payload.data(), payload.size());
    payload = SharedBytes(slab->data(), payload.size(), slab);
  }
  // Fields with higher numbers now stand before the payload: any order of fields is valid.
  encoded.prefix = payload_prefix(payload.size());
  encoded.payload = std::move(payload);
  encoded.slab = std::move(slab);
  return encoded;
}

EncodedMessage encode_raw(std::string bytes) {
  check_size(bytes.size(), "a message");
  EncodedMessage encoded;
  encoded.body = SharedBytes::of(std::move(bytes));
  return encoded;
}

bool is_consistent(const EncodedMessage& message) {
  if (message.payload.empty()) return message.prefix.empty();
  const SharedBytes expected = payload_prefix(message.payload.size());
  return message.prefix.size() == expected.size() &&
         std::memcmp(message.prefix.data(), expected.data(), expected.size()) == 0;
}

std::int64_t header_stamp(const Message& message) {
  const Layout layout = layout_of(message);
  if (!layout.stamp) return 0;
  const Message& header = message.GetReflection()->GetMessage(message, layout.header);
  return header.GetReflection()->GetInt64(header, layout.stamp);
}

SharedBytes take_payload(Message& message) {
  const std::string* content = payload_of(message);
  // A field in an arena is not the message's own.
  if (!content || content->size() < kApartPays || message.GetArena() != nullptr) return {};
  auto taken = SharedBytes::of(std::move(const_cast<std::string&>(*content)));
  message.GetReflection()->ClearField(&message, payload_field(message));
  return taken;
}

void check_payload_comes_apart(const Message& message) {
  const FieldDescriptor* field = payload_field(message);
  if (!field) {
    throw std::invalid_argument(message.GetTypeName() + " has no payload: no bytes field 15");
  }
  if (message.GetReflection()->HasField(message, field)) {
    throw std::invalid_argument(message.GetTypeName() + ": field '" + field->name() +
                                "' is set and a payload is given apart; use one of both");
  }
}

Content::Content(EncodedMessage encoded)
    : bytes_(encoded.bytes()), is_encoded_(true), encoded_(std::move(encoded)) {}

Content::Content(std::shared_ptr<const Message> object, SharedBytes payload,
                 std::shared_ptr<Slab> slab, std::shared_ptr<SlabPool> pool)
    : object_(std::move(object)),
      payload_(std::move(payload)),
      bytes_(object_->ByteSizeLong() + payload_.size()),
      slab_(std::move(slab)),
      pool_(std::move(pool)) {
  check_size(bytes_, object_->GetTypeName());
}

const EncodedMessage& Content::encoded() const {
  if (is_encoded_.load(std::memory_order_acquire)) return encoded_;
  const std::lock_guard lock(encoding_);
  if (is_encoded_.load(std::memory_order_relaxed)) return encoded_;
  encoded_ = payload_.empty() ? encode(*object_, pool_)
                              : encode_with_payload(*object_, payload_, std::move(slab_), pool_);
  pool_.reset();
  is_encoded_.store(true, std::memory_order_release);
  return encoded_;
}

bool take_parts(const Content& content, const Message& prototype, MessageParts& parts) {
  const auto& object = content.object();
  const Message* same = object.get();
  if (same && typeid(*same) == typeid(prototype)) {
    parts.body = object;
    const SharedBytes& apart = content.payload_apart();
    parts.payload_is_apart = !apart.empty();
    parts.payload = apart.span();
    parts.payload_owner = apart.owner();
  } else {
    const EncodedMessage& encoded = content.encoded();
    std::shared_ptr<Message> body(prototype.New());
    if (!body->ParseFromArray(encoded.body.data(), static_cast<int>(encoded.body.size()))) {
      return false;
    }
    parts.body = std::move(body);
    parts.payload_is_apart = !encoded.payload.empty();
    parts.payload = encoded.payload.span();
    parts.payload_owner = encoded.payload.owner();
  }
  if (parts.payload_is_apart) return payload_field(*parts.body) != nullptr;
  if (const std::string* payload = payload_of(*parts.body)) {
    parts.payload = {reinterpret_cast<const std::uint8_t*>(payload->data()), payload->size()};
  }
  return true;
}

void set_payload(Message& message, std::span<const std::uint8_t> payload) {
  message.GetReflection()->SetString(
      &message, payload_field(message),
      std::string(reinterpret_cast<const char*>(payload.data()), payload.size()));
}

}  // namespace prehend::graph
