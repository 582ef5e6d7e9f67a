#pragma once

#include <algorithm>
#include <cmath>
#include <numbers>

#include "drivers/kuka_rsi/codec/telegram.h"

namespace prehend::drivers::kuka_rsi {

inline constexpr double kDegree = std::numbers::pi / 180;  // rad
inline constexpr double kSamePlace = 0.01;  // rad, of an arm that holds what was sent last

inline Axes to_radians(const Axes& degrees) {
  Axes radians{};
  for (std::size_t i = 0; i < kAxes; ++i) radians[i] = degrees[i] * kDegree;
  return radians;
}

inline double largest_difference(const Axes& a, const Axes& b) {
  double most = 0;
  for (std::size_t i = 0; i < kAxes; ++i) most = std::max(most, std::abs(a[i] - b[i]));
  return most;
}

}  // namespace prehend::drivers::kuka_rsi
