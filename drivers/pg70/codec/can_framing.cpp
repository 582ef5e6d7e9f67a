#include "drivers/pg70/codec/can_framing.h"

namespace prehend::drivers::pg70 {
namespace {

constexpr std::uint8_t kStart = 0x84, kMiddle = 0x85, kEnd = 0x86;

bool is_fragment(const CanFrame& frame) {
  return frame.size >= 2 && frame.data[1] >= kStart && frame.data[1] <= kEnd;
}

}  // namespace

std::optional<Direction> can_direction(std::uint16_t identifier) {
  if ((identifier & 0xFF) == 0) return std::nullopt;
  switch (identifier & 0x700) {
    case 0x500:
      return Direction::kCommand;
    case 0x700:
      return Direction::kResponse;
    case 0x300:
      return Direction::kError;
    default:
      return std::nullopt;
  }
}

void FrameAssembler::give_up() {
  if (expected_ > 0) ++broken_;
  expected_ = 0;
  partial_.clear();
}

std::optional<Content> FrameAssembler::add(const CanFrame& frame) {
  if (frame.size > frame.data.size()) {
    ++broken_;
    return std::nullopt;
  }
  if (is_fragment(frame)) return add_fragment(frame);
  give_up();
  const std::size_t length = frame.size > 0 ? frame.data[0] : 0;
  if (length == 0 || length > frame.size - 1u) {
    ++broken_;
    return std::nullopt;
  }
  return Content(Bytes(frame.data).subspan(1, length));
}

std::optional<Content> FrameAssembler::add_fragment(const CanFrame& frame) {
  const std::size_t remaining = frame.data[0];
  const std::uint8_t kind = frame.data[1];
  const std::size_t count = std::min<std::size_t>({remaining, frame.size - 2u, 6});
  if (kind == kEnd && remaining == 0 && expected_ == 0) return std::nullopt;  // an empty third one
  if (kind == kStart) {
    give_up();
    expected_ = remaining;
  }
  // A middle one may not be the last of the bytes, an end one has to be.
  const bool fits = expected_ > 0 && remaining == expected_ && count > 0 &&
                    (kind == kEnd ? count == remaining : count == 6 || kind == kStart);
  if (!fits) {
    if (expected_ == 0) ++broken_;
    give_up();
    return std::nullopt;
  }
  partial_.append(Bytes(frame.data).subspan(2, count));
  expected_ -= count;
  if (expected_ > 0) return std::nullopt;
  const Content whole = partial_;
  partial_.clear();
  return whole;
}

}  // namespace prehend::drivers::pg70
