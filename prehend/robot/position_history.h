#pragma once

#include <cstdint>
#include <deque>
#include <optional>
#include <utility>

#include "prehend/robot/kinematic_chain.h"

namespace prehend::robot {

/// Where a chain's joints were in the last seconds.
class PositionHistory {
 public:
  /// All times in ns, of one clock. @param span that is kept, > 0. @param gap between two entries
  /// that is bridged, and after the last one, >= 0.
  explicit PositionHistory(std::int64_t span = 2'000'000'000, std::int64_t gap = 50'000'000)
      : span_(span), gap_(gap) {}

  /// A time that is not later than the last one begins the history anew: the clock was set back.
  void add(std::int64_t time, Positions positions);
  /// Linear between the entries round it, the last entry up to `gap` after it; none: before the
  /// first, later, or in a hole.
  std::optional<Positions> at(std::int64_t time) const;

 private:
  std::int64_t span_, gap_;
  std::deque<std::pair<std::int64_t, Positions>> entries_;
};

}  // namespace prehend::robot
