#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>

#include <Eigen/Geometry>

namespace prehend::simulation {

/// The same numbers on every machine, which the standard's distributions need not give.
class RandomDraw {
 public:
  explicit RandomDraw(std::uint64_t seed) : random_(seed) {}

  double unit() { return static_cast<double>(random_() >> 11) * 0x1.0p-53; }  // in [0, 1)
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// 0 to count - 1. @pre count > 0
  std::size_t one_of(std::size_t count) {
    return std::min(count - 1, static_cast<std::size_t>(unit() * static_cast<double>(count)));
  }
  /// Uniform (K. Shoemake, "Uniform Random Rotations", Graphics Gems III, 1992).
  Eigen::Quaterniond rotation() {
    const double a = unit(), b = 2 * std::numbers::pi * unit(), c = 2 * std::numbers::pi * unit();
    return {std::sqrt(a) * std::cos(c), std::sqrt(1 - a) * std::sin(b),
            std::sqrt(1 - a) * std::cos(b), std::sqrt(a) * std::sin(c)};
  }

 private:
  std::mt19937_64 random_;
};

}  // namespace prehend::simulation
