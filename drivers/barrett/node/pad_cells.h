#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "drivers/barrett/codec/tactile.h"
#include "msgs/sensors.pb.h"
#include "prehend/robot/hand_model.h"

namespace prehend::drivers::barrett {

/// Where the 24 cells of a puck are in the grid of a hand's pad: 8 x 3, or 7 x 4 without corners,
/// row by row, row 0 nearest the fingertip. That cells come in this order is not confirmed:
/// `order[i]` is the place among them of the puck's cell i.
class PadCells {
 public:
  /// @param order a permutation of 0 to 23; empty: as they come.
  /// @throws geometry::InputError for a hand without that pad, one whose grid has not 24 cells, and
  /// an order that is no permutation.
  PadCells(const robot::HandModel& hand, const std::string& pad,
           const std::vector<std::size_t>& order);

  const std::string& name() const { return name_; }
  msgs::TactileFrame message(const Cells& cells, std::int64_t stamp) const;
  /// The other way round: what a puck tells of such a frame. Cells that it lacks are 0.
  Cells cells(const msgs::TactileFrame& frame) const;

 private:
  std::string name_;
  robot::TactilePadModel model_;
  std::array<std::size_t, kCells> place_{};  // in the grid
};

}  // namespace prehend::drivers::barrett
