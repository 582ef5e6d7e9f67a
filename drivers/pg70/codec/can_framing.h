#pragma once

#include <cstdint>
#include <optional>

#include "drivers/pg70/codec/message.h"
#include "drivers/wire/can/can_frame.h"

namespace prehend::drivers::pg70 {

/// Identifier of a message to or from `module` (1..255): kind in bits 8..10, module in bits 0..7
/// (manual V1.41, pages 12, 314, 315).
constexpr std::uint16_t can_identifier(Direction direction, std::uint8_t module) {
  const std::uint16_t base = direction == Direction::kCommand    ? 0x500
                             : direction == Direction::kResponse ? 0x700
                                                                 : 0x300;
  return static_cast<std::uint16_t>(base | module);
}

/// The direction that an identifier stands for; nothing for other ids (group commands included).
std::optional<Direction> can_direction(std::uint16_t identifier);

/// Most frames of one message: 255 bytes, 6 in each.
inline constexpr int kMostFrames = 43;

/// The frames of a message (manual V1.41, page 14). Up to 7 bytes: one frame [D-Len][content].
/// More: [remaining][0x84 start | 0x85 middle | 0x86 end][up to 6 bytes], `remaining` = content
/// bytes still to come, those of this frame included. Calls `take(const CanFrame&)` for each.
template <class Take>
void split_into_frames(std::uint16_t identifier, const Content& content, Take&& take);

/// Puts the frames of one identifier together again. What is damaged is dropped and counted; the
/// next start or unfragmented frame begins anew. DLC 8 on a last fragment (padding) and an empty
/// end fragment after the message is complete are accepted, as real senders do both.
class FrameAssembler {
 public:
  /// The message that this frame completes, if any.
  std::optional<Content> add(const CanFrame& frame);

  /// Messages that were given up: fragments missing, out of order, or lengths that contradict.
  std::uint64_t broken() const { return broken_; }
  bool is_partial() const { return expected_ > 0; }
  /// Forgets a message begun, e.g. after a silence. Counts it as broken.
  void give_up();

 private:
  std::optional<Content> add_fragment(const CanFrame& frame);

  Content partial_;
  std::size_t expected_ = 0;  // bytes still to come; 0: no message begun
  std::uint64_t broken_ = 0;
};

// --- implementation ---------------------------------------------------------------------------

template <class Take>
void split_into_frames(std::uint16_t identifier, const Content& content, Take&& take) {
  constexpr std::size_t kWhole = 7, kPart = 6;
  Bytes rest = content.bytes();
  CanFrame frame;
  frame.identifier = identifier;
  const auto fill = [&](std::size_t header, std::size_t count) {
    std::copy_n(rest.data(), count, frame.data.begin() + header);
    frame.size = static_cast<std::uint8_t>(header + count);
    rest = rest.subspan(count);
    take(static_cast<const CanFrame&>(frame));
  };
  frame.data[0] = static_cast<std::uint8_t>(rest.size());
  if (rest.size() <= kWhole) return fill(1, rest.size());
  std::uint8_t kind = 0x84;
  while (!rest.empty()) {
    if (rest.size() <= kPart) kind = 0x86;
    frame.data[0] = static_cast<std::uint8_t>(rest.size());
    frame.data[1] = kind;
    fill(2, std::min(rest.size(), kPart));
    kind = 0x85;
  }
}

}  // namespace prehend::drivers::pg70
