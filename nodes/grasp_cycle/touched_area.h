#pragma once

#include <algorithm>
#include <cstdint>

#include "msgs/sensors.pb.h"

namespace prehend::nodes {

/// Area [m^2] of a pad's texels that show more than `counts`.
inline double touched_area(const msgs::TactileFrame& frame, int counts) {
  const auto touched = std::count_if(
      frame.intensity().begin(), frame.intensity().end(),
      [counts](std::uint32_t value) { return value > static_cast<std::uint32_t>(counts); });
  return static_cast<double>(touched) * frame.texel_width() * frame.texel_height();
}

}  // namespace prehend::nodes
