#pragma once

#include <array>
#include <cstdint>
#include <optional>

#include "drivers/barrett/codec/message.h"

namespace prehend::drivers::barrett {

using Cells = std::array<std::uint16_t, kCells>;

/// Puts a pad's images together from its frames; one that lacks a frame, or has them out of order,
/// is thrown away.
class TactileAssembler {
 public:
  /// The image that this frame ends.
  std::optional<Cells> add(const TactilePart& part);
  /// Frames that were of no use.
  std::uint64_t broken() const { return broken_; }

 private:
  Cells cells_{};
  std::uint8_t next_ = 0;
  std::uint64_t broken_ = 0;
};

/// The frames of an image.
std::array<TactilePart, kTactileFrames> split(std::size_t axis, const Cells& cells);

}  // namespace prehend::drivers::barrett
