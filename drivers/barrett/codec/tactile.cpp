#include "drivers/barrett/codec/tactile.h"

namespace prehend::drivers::barrett {

std::optional<Cells> TactileAssembler::add(const TactilePart& part) {
  if (part.sequence != next_) {
    broken_ += 1 + std::uint64_t{next_};
    next_ = 0;
    if (part.sequence != 0) return {};
    --broken_;  // an image begins
  }
  for (std::size_t i = 0; i < kCellsPerFrame; ++i) {
    const std::size_t cell = part.sequence * kCellsPerFrame + i;
    if (cell < kCells) cells_[cell] = part.cells[i];
  }
  if (++next_ < kTactileFrames) return {};
  next_ = 0;
  return cells_;
}

std::array<TactilePart, kTactileFrames> split(std::size_t axis, const Cells& cells) {
  std::array<TactilePart, kTactileFrames> parts{};
  for (std::size_t p = 0; p < kTactileFrames; ++p) {
    parts[p].axis = axis;
    parts[p].sequence = static_cast<std::uint8_t>(p);
    for (std::size_t i = 0; i < kCellsPerFrame && p * kCellsPerFrame + i < kCells; ++i) {
      parts[p].cells[i] = cells[p * kCellsPerFrame + i];
    }
  }
  return parts;
}

}  // namespace prehend::drivers::barrett
