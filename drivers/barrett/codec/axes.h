#pragma once

#include <array>
#include <cstddef>

namespace prehend::drivers::barrett {

/// Fingers 1, 2 and 3, and the spread, which turns fingers 1 and 2 opposite ways.
inline constexpr std::size_t kAxes = 4;
inline constexpr std::size_t kSpread = 3;
using AxisValues = std::array<double, kAxes>;

/// "F1", "F2", "F3", "spread".
const char* axis_name(std::size_t axis);

}  // namespace prehend::drivers::barrett
