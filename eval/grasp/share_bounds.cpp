#include "eval/grasp/share_bounds.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

namespace prehend::eval {

ShareBounds share_bounds(int held, int tried) {
  if (tried <= 0) return {};
  constexpr double z = 1.959963984540054;
  const double n = tried, p = held / n;
  const double middle = (p + z * z / (2 * n)) / (1 + z * z / n);
  const double half = z / (1 + z * z / n) * std::sqrt(p * (1 - p) / n + z * z / (4 * n * n));
  return {std::max(0.0, middle - half), std::min(1.0, middle + half)};
}

std::string to_string(const ShareBounds& bounds) {
  return fmt::format("{:.1f} to {:.1f}", 100 * bounds.low, 100 * bounds.high);
}

}  // namespace prehend::eval
