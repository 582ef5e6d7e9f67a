#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <variant>

#include "drivers/barrett/codec/puck.h"
#include "drivers/wire/can/can_frame.h"

namespace prehend::drivers::barrett {

/// What the host says to a puck: a question, or (with a value) an order, which is not answered.
struct Request {
  std::size_t axis = 0;
  std::uint8_t property = 0;  // 0..127
  std::optional<std::int32_t> value = {};

  friend bool operator==(const Request&, const Request&) = default;
};
/// 1 byte, or 4 and 6 with a value of 16 and 32 bits: the value is cut to that.
CanFrame encode(const Request& request);
/// Of a puck's end of the bus; nothing for frames that are no host's request to one of the hand's.
std::optional<Request> decode_request(const CanFrame& frame);

/// The answer to a question.
struct Value {
  std::size_t axis = 0;
  std::uint8_t property = 0;
  std::int32_t value = 0;

  friend bool operator==(const Value&, const Value&) = default;
};
/// The same of P: 22 bits, high byte first, and of fingers that have an encoder behind the clutch
/// its counts, too.
struct Position {
  std::size_t axis = 0;
  std::int32_t motor = 0;  // counts
  std::optional<std::int32_t> joint = {};

  friend bool operator==(const Position&, const Position&) = default;
};
inline constexpr std::int32_t kMostPosition = (1 << 21) - 1, kLeastPosition = -(1 << 21);

/// One of the five frames of a pad's image, five cells each; of the last one four count.
inline constexpr std::size_t kCellsPerFrame = 5, kTactileFrames = 5;
struct TactilePart {
  std::size_t axis = 0;
  std::uint8_t sequence = 0;  // 0..15; 0..4 make an image
  std::array<std::uint16_t, kCellsPerFrame> cells{};

  friend bool operator==(const TactilePart&, const TactilePart&) = default;
};

using Reply = std::variant<Value, Position, TactilePart>;
CanFrame encode(const Value& value);
CanFrame encode(const Position& position);  // cut to 22 bits
CanFrame encode(const TactilePart& part);
/// Nothing for frames that are no reply of one of the hand's pucks.
std::optional<Reply> decode_reply(const CanFrame& frame);

}  // namespace prehend::drivers::barrett
