#include "drivers/barrett/codec/message.h"

#include "drivers/wire/encoding/byte_order.h"

namespace prehend::drivers::barrett {
namespace {

constexpr std::uint8_t kSets = 0x80;
constexpr std::uint8_t kNarrowSize = 4, kWideSize = 6, kPositionBytes = 3;

void put_value(CanFrame& frame, std::uint8_t property, std::int32_t value) {
  frame.data[0] = static_cast<std::uint8_t>(kSets | property);
  frame.data[1] = 0;
  if (is_wide(property)) {
    store_little<std::int32_t>(&frame.data[2], value);
    frame.size = kWideSize;
  } else {
    store_little<std::int16_t>(&frame.data[2], static_cast<std::int16_t>(value));
    frame.size = kNarrowSize;
  }
}

// Pucks and hosts send 16-bit properties with 4 or 6 bytes (libbarrett sets all with 6).
std::optional<std::int32_t> value_of(const CanFrame& frame) {
  if (frame.size < kNarrowSize || (frame.data[0] & kSets) == 0 || frame.data[1] != 0) return {};
  if (frame.size == kNarrowSize) return load_little<std::int16_t>(&frame.data[2]);
  if (frame.size == kWideSize) return load_little<std::int32_t>(&frame.data[2]);
  return {};
}

void put_position(std::uint8_t* bytes, std::int32_t value) {
  const auto bits = static_cast<std::uint32_t>(value);
  bytes[0] = static_cast<std::uint8_t>(kSets | (bits >> 16 & 0x3F));
  bytes[1] = static_cast<std::uint8_t>(bits >> 8);
  bytes[2] = static_cast<std::uint8_t>(bits);
}

std::optional<std::int32_t> position_of(const std::uint8_t* bytes) {
  if ((bytes[0] & 0xC0) != kSets) return {};
  const std::int32_t value = (bytes[0] & 0x3F) << 16 | bytes[1] << 8 | bytes[2];
  return value > kMostPosition ? value - (1 << 22) : value;
}

std::optional<Reply> position_reply(std::size_t axis, const CanFrame& frame) {
  if (frame.size != kPositionBytes && frame.size != 2 * kPositionBytes) return {};
  const auto motor = position_of(frame.data.data());
  if (!motor) return {};
  Position position{axis, *motor};
  if (frame.size == 2 * kPositionBytes) {
    position.joint = position_of(&frame.data[kPositionBytes]);
    if (!position.joint) return {};
  }
  return position;
}

}  // namespace

CanFrame encode(const Request& request) {
  CanFrame frame;
  frame.identifier = request_identifier(request.axis);
  if (request.value) {
    put_value(frame, request.property, *request.value);
  } else {
    frame.size = 1;
    frame.data[0] = request.property & static_cast<std::uint8_t>(~kSets);
  }
  return frame;
}

std::optional<Request> decode_request(const CanFrame& frame) {
  if (frame.identifier < kFirstPuck || frame.identifier >= kFirstPuck + kAxes) return {};
  const auto axis = static_cast<std::size_t>(frame.identifier - kFirstPuck);
  if (frame.size == 1 && (frame.data[0] & kSets) == 0) return Request{axis, frame.data[0]};
  const auto value = value_of(frame);
  if (!value) return {};
  return Request{axis, static_cast<std::uint8_t>(frame.data[0] & ~kSets), value};
}

CanFrame encode(const Value& value) {
  CanFrame frame;
  frame.identifier = reply_identifier(value.axis, Group::kReply);
  put_value(frame, value.property, value.value);
  return frame;
}

CanFrame encode(const Position& position) {
  CanFrame frame;
  frame.identifier = reply_identifier(position.axis, Group::kPosition);
  frame.size = kPositionBytes;
  put_position(frame.data.data(), position.motor);
  if (position.joint) {
    frame.size = 2 * kPositionBytes;
    put_position(&frame.data[kPositionBytes], *position.joint);
  }
  return frame;
}

// Twelve bits a cell behind four of the sequence number, most significant first.
CanFrame encode(const TactilePart& part) {
  CanFrame frame;
  frame.identifier = reply_identifier(part.axis, Group::kTactileAll);
  frame.size = 8;
  std::uint64_t bits = part.sequence & 0xFU;
  for (const std::uint16_t cell : part.cells) bits = bits << 12 | (cell & kMostCellCount);
  for (int i = 7; i >= 0; --i, bits >>= 8) {
    frame.data[static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(bits);
  }
  return frame;
}

std::optional<Reply> decode_reply(const CanFrame& frame) {
  const std::size_t sender = frame.identifier >> kSenderShift & kReceiverMask;
  if ((frame.identifier & kToGroup) == 0 || sender < kFirstPuck || sender >= kFirstPuck + kAxes) {
    return {};
  }
  const std::size_t axis = sender - kFirstPuck;
  switch (static_cast<Group>(frame.identifier & kReceiverMask)) {
    case Group::kReply: {
      const auto value = value_of(frame);
      if (!value) return {};
      return Value{axis, static_cast<std::uint8_t>(frame.data[0] & ~kSets), *value};
    }
    case Group::kPosition:
      return position_reply(axis, frame);
    case Group::kTactileAll: {
      if (frame.size != 8) return {};
      std::uint64_t bits = 0;
      for (const std::uint8_t byte : frame.data) bits = bits << 8 | byte;
      TactilePart part{axis, static_cast<std::uint8_t>(bits >> 60)};
      for (std::size_t i = kCellsPerFrame; i-- > 0; bits >>= 12) {
        part.cells[i] = static_cast<std::uint16_t>(bits & kMostCellCount);
      }
      return part;
    }
  }
  return {};
}

}  // namespace prehend::drivers::barrett
