// A published message as it comes from the network: `kind byte | envelope run | body run | prefix
// run | payload`, or, with bit 7 of the kind, `kind byte | batch`. What can be decoded is encoded
// again in every way there is and must stay the same.

#include <memory>
#include <string>
#include <vector>

#include "msgs/geometry.pb.h"
#include "msgs/objects.pb.h"
#include "msgs/sensors.pb.h"
#include "prehend/graph/link/content.h"
#include "prehend/graph/link/frames.h"
#include "tests/fuzz/fuzz_input.h"
#include "tests/fuzz/quiet_protobuf.h"

namespace {

using google::protobuf::Message;
using prehend::fuzz::FuzzInput;
using namespace prehend::graph;

std::unique_ptr<Message> message_of(std::uint8_t kind) {
  switch (kind % 5) {
    case 0:
      return std::make_unique<prehend::msgs::PointCloud>();
    case 1:
      return std::make_unique<prehend::msgs::StereoPair>();
    case 2:
      return std::make_unique<prehend::msgs::Clock>();
    case 3:
      return std::make_unique<prehend::msgs::CompletedShape>();
    default:
      return std::make_unique<prehend::msgs::graph::PeerMessage>();
  }
}

SharedBytes shared(std::string_view bytes) {
  return SharedBytes::copy_of(bytes.data(), bytes.size());
}

// What a subscriber's callback sees as the whole message; null when it is damaged.
std::unique_ptr<Message> received(const EncodedMessage& encoded, const Message& prototype) {
  MessageParts parts;
  if (!take_parts(Content(encoded), prototype, parts)) return nullptr;
  std::unique_ptr<Message> whole(prototype.New());
  whole->CopyFrom(*parts.body);
  if (parts.payload_is_apart) set_payload(*whole, parts.payload);
  return whole;
}

void check_same(const EncodedMessage& encoded, const Message& message) {
  const auto again = received(encoded, message);
  FUZZ_CHECK(again && again->SerializeAsString() == message.SerializeAsString());
}

void check_message(FuzzInput& input, std::uint8_t kind) {
  const std::unique_ptr<Message> message = message_of(kind);
  prehend::msgs::graph::Envelope envelope;
  const std::string_view envelope_bytes = input.run();
  envelope.ParseFromArray(envelope_bytes.data(), static_cast<int>(envelope_bytes.size()));
  EncodedMessage encoded;
  encoded.body = shared(input.run());
  encoded.prefix = shared(input.run());
  encoded.payload = shared(input.rest());
  const std::string whole = encoded.concatenated();
  FUZZ_CHECK(whole.size() == encoded.bytes());
  if (!is_consistent(encoded)) return;  // a subscriber counts it as malformed
  const auto seen = received(encoded, *message);
  if (!seen) return;
  // A recorder sees the parts put together; it must be the same message.
  FUZZ_CHECK(message->ParseFromString(whole));
  FUZZ_CHECK(seen->SerializeAsString() == message->SerializeAsString());
  header_stamp(*message);
  check_same(encode(*message), *message);
  check_same(encode_raw(whole), *message);
  SharedBytes payload = take_payload(*seen);
  if (!payload.empty()) check_same(encode_with_payload(*seen, payload, nullptr), *message);
}

void check_batch(FuzzInput& input) {
  std::vector<OutgoingMessage> messages;
  const bool whole = read_batch(shared(input.rest()), [&](const BatchRecord& record) {
    EncodedMessage encoded;
    encoded.body = record.encoded;
    messages.push_back({std::make_shared<Content>(std::move(encoded)), messages.size() + 1,
                        record.stamp, record.publish_time});
  });
  if (!whole || messages.empty()) return;
  const Frames frames = to_wire(TopicHead{"/topic", "sender", 1}, messages);
  FUZZ_CHECK(frames.size() == 3 && frames[2].to_string_view() == input.rest());
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  prehend::fuzz::quiet_protobuf();
  FuzzInput input(data, size);
  const std::uint8_t kind = input.byte();
  if (kind & 0x80) {
    check_batch(input);
  } else {
    check_message(input, kind);
  }
  return 0;
}
