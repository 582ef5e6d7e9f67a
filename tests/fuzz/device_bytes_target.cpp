// What devices send: `kind byte | bytes`, or for CAN `kind byte | (size byte | data)...`. Whatever
// is decoded encodes to the bytes it came from, and no decoder keeps more than it was given.

#include <algorithm>
#include <string_view>
#include <variant>
#include <vector>

#include "drivers/camera/codec/depth_wire.h"
#include "drivers/dsa/codec/frame.h"
#include "drivers/dsa/codec/packet.h"
#include "drivers/dsa/codec/structures.h"
#include "drivers/ft300/codec/measurement.h"
#include "drivers/ft300/codec/modbus_rtu.h"
#include "drivers/pg70/codec/can_framing.h"
#include "drivers/pg70/codec/request.h"
#include "drivers/pg70/codec/response.h"
#include "drivers/pg70/codec/serial_framing.h"
#include "tests/fuzz/fuzz_input.h"

namespace {

using namespace prehend::drivers;
using prehend::fuzz::FuzzInput;

Bytes bytes_of(std::string_view text) {
  return {reinterpret_cast<const std::uint8_t*>(text.data()), text.size()};
}

void check_content(const pg70::Content& content) {
  FUZZ_CHECK(content.size() > 0);
  FUZZ_CHECK(pg70::encode(pg70::decode_request(content)) == content);
  for (std::uint8_t mode = 0; mode < 8; ++mode) {
    FUZZ_CHECK(pg70::encode(pg70::decode_response(content, mode)) == content);
  }
}

void fuzz_can(FuzzInput& input) {
  pg70::FrameAssembler assembler;
  while (!input.is_empty()) {
    CanFrame frame{.identifier = 0x701, .size = input.byte()};
    for (std::size_t i = 0; i < std::min<std::size_t>(frame.size, 8); ++i) {
      frame.data[i] = input.byte();
    }
    const auto content = assembler.add(frame);
    if (content) check_content(*content);
  }
}

void fuzz_serial(Bytes bytes) {
  pg70::SerialDecoder decoder;
  decoder.add(bytes);
  std::size_t consumed = 0;
  while (const auto message = decoder.next()) {
    check_content(message->content);
    consumed += pg70::encode_serial(*message).size();
  }
  FUZZ_CHECK(consumed + decoder.discarded() <= bytes.size());
}

void check_structures(Bytes payload) {
  using namespace dsa;
  const auto same = [&](const auto& info) {
    if (info) FUZZ_CHECK(std::ranges::equal(encode(*info), payload));
  };
  if (payload.size() != 19) same(decode_controller_info(payload));
  same(decode_sensor_info(payload));
  same(decode_matrix_info(payload));
  same(decode_sensitivity_info(payload));
  same(decode_acquisition(payload));
  same(decode_set_sensitivity(payload));
  same(decode_set_threshold(payload));
  if (payload.size() != 2) same(decode_threshold_info(payload));
}

void fuzz_dsa(Bytes bytes) {
  dsa::PacketDecoder decoder(4096);
  decoder.add(bytes);
  std::size_t consumed = 0;
  dsa::Frame frame;
  while (const auto packet = decoder.next()) {
    FUZZ_CHECK(packet->payload.size() <= 4096);
    consumed += dsa::encode_packet(packet->id, packet->payload).size();
    check_structures(packet->payload);
  }
  FUZZ_CHECK(consumed + decoder.discarded() <= bytes.size());
  // The same bytes as a frame's payload, and as a structure.
  check_structures(bytes);
  for (const std::size_t texels : {std::size_t{0}, std::size_t{84}, bytes.size() / 2}) {
    if (!dsa::decode_frame(bytes, texels, frame)) continue;
    FUZZ_CHECK(frame.texels.size() == texels);
    dsa::Frame again;
    FUZZ_CHECK(dsa::decode_frame(dsa::encode_frame(frame, true), texels, again) && again == frame);
  }
}

void fuzz_modbus(Bytes bytes) {
  using namespace ft300;
  StreamDecoder stream;
  stream.add(bytes);
  std::size_t measurements = 0;
  while (stream.next()) ++measurements;
  FUZZ_CHECK(measurements * kStreamMessageSize + stream.discarded() <= bytes.size());
  RtuRequestDecoder requests;
  requests.add(bytes);
  while (const auto message = requests.next()) {
    const auto request = decode_request_pdu(message->pdu);
    if (!request || std::holds_alternative<UnknownRequest>(*request)) continue;
    FUZZ_CHECK(encode_pdu(*request) == message->pdu);
  }
  if (const auto reply = decode_reply_pdu(bytes)) {
    FUZZ_CHECK(std::ranges::equal(encode_pdu(*reply), bytes));
  }
  std::vector<std::uint8_t> buffer(bytes.begin(), bytes.end());
  bool broken = false;
  while (take_tcp(buffer, broken)) FUZZ_CHECK(!broken);
}

void fuzz_depth_wire(Bytes bytes) {
  if (const auto number = camera::decode_question(bytes)) {
    FUZZ_CHECK(std::ranges::equal(camera::encode_question(*number), bytes));
  }
  if (bytes.size() < camera::kAnswerHeaderSize) return;
  auto picture = camera::decode_answer_header(bytes.first(camera::kAnswerHeaderSize));
  if (!picture || bytes.size() != camera::kAnswerHeaderSize + camera::picture_size(*picture))
    return;
  camera::decode_picture(bytes.subspan(camera::kAnswerHeaderSize), *picture);
  if (picture->width > 0) FUZZ_CHECK(std::ranges::equal(camera::encode_answer(*picture), bytes));
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  FuzzInput input(data, size);
  switch (input.byte() % 5) {
    case 0:
      fuzz_can(input);
      break;
    case 1:
      fuzz_serial(bytes_of(input.rest()));
      break;
    case 2:
      fuzz_dsa(bytes_of(input.rest()));
      break;
    case 4:
      fuzz_depth_wire(bytes_of(input.rest()));
      break;
    default:
      fuzz_modbus(bytes_of(input.rest()));
  }
  return 0;
}
