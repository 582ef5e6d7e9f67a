#include "drivers/barrett/node/pad_cells.h"

#include <algorithm>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/text/nearest_match.h"

namespace prehend::drivers::barrett {

PadCells::PadCells(const robot::HandModel& hand, const std::string& pad,
                   const std::vector<std::size_t>& order)
    : name_(pad) {
  std::vector<std::string> names;
  for (const robot::HandPad& one : hand.pads) names.push_back(one.name);
  const auto found = std::ranges::find(hand.pads, pad, &robot::HandPad::name);
  if (found == hand.pads.end()) {
    throw geometry::InputError(
        fmt::format("hand {} has no pad '{}'{}", hand.name, pad,
                    text::nearest_match_hint(pad, names)),
        "Give pads:= the hand's pads in the order of the pucks, or \"[]\" for none");
  }
  model_ = found->model;
  std::vector<std::size_t> grid;
  for (std::size_t i = 0; i < found->layout->size(); ++i) {
    if (found->layout->area(i) > 0) grid.push_back(i);
  }
  if (grid.size() != kCells) {
    throw geometry::InputError(
        fmt::format("pad '{}' of hand {} has {} cells, a puck tells {}", pad, hand.name,
                    grid.size(), kCells),
        "Its grid has to be that of a BH8-280's pad, as in config/robots/bh8.yaml");
  }
  std::vector<bool> is_taken(kCells);
  for (std::size_t i = 0; i < kCells; ++i) {
    const std::size_t at = order.empty() ? i : i < order.size() ? order[i] : kCells;
    if (at >= kCells || is_taken[at] || (!order.empty() && order.size() != kCells)) {
      throw geometry::InputError("the order of a pad's cells is no permutation of 0 to 23",
                                 "Give each of the 24 places once");
    }
    is_taken[at] = true;
    place_[i] = grid[at];
  }
}

msgs::TactileFrame PadCells::message(const Cells& cells, std::int64_t stamp) const {
  msgs::TactileFrame message;
  message.mutable_header()->set_stamp(stamp);
  message.mutable_header()->set_frame_id(name_);
  message.set_rows(static_cast<std::uint32_t>(model_.rows));
  message.set_columns(static_cast<std::uint32_t>(model_.columns));
  message.set_texel_width(model_.texel_pitch);
  message.set_texel_height(model_.texel_pitch);
  message.set_full_scale(kMostCellCount);
  message.set_newton_per_count(model_.newton_per_count);
  message.mutable_intensity()->Resize(model_.rows * model_.columns, 0);
  double sum = 0;
  for (std::size_t i = 0; i < kCells; ++i) {
    message.set_intensity(static_cast<int>(place_[i]), cells[i]);
    sum += cells[i];
  }
  message.set_sum(sum * model_.newton_per_count);
  return message;
}

Cells PadCells::cells(const msgs::TactileFrame& frame) const {
  Cells cells{};
  for (std::size_t i = 0; i < kCells; ++i) {
    if (place_[i] >= static_cast<std::size_t>(frame.intensity_size())) continue;
    const std::uint32_t count = frame.intensity(static_cast<int>(place_[i]));
    cells[i] = static_cast<std::uint16_t>(std::min<std::uint32_t>(count, kMostCellCount));
  }
  return cells;
}

}  // namespace prehend::drivers::barrett
