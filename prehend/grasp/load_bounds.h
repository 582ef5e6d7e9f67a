#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

namespace prehend::grasp {

/// Between what a number is known to be; unbounded where nothing says more.
struct Interval {
  double low = 0;
  double high = std::numeric_limits<double>::infinity();

  bool is_known() const { return low > 0 || std::isfinite(high); }
  bool is_empty() const { return !(low <= high); }
  Interval narrowed(const Interval& other) const {
    return {std::max(low, other.low), std::min(high, other.high)};
  }
};

/// What was found out of an object's load on a hand: by weighing it, and by how it slipped or held.
struct LoadBounds {
  Interval mass;      // kg
  Interval friction;  // of the hand's pads on it, Coulomb's coefficient

  bool is_known() const { return mass.is_known() || friction.is_known(); }
};

/// What was assumed, positive and finite, within what was found out, which goes before it. An
/// assumption wholly beside that is scaled to end where that begins: of 0.5 to 0.8 and at most 0.4
/// there remains 0.25 to 0.4.
inline Interval within(const Interval& assumed, const Interval& found) {
  const Interval both = assumed.narrowed(found);
  if (!both.is_empty()) return both;
  const double ratio = assumed.low / assumed.high;
  if (found.high < assumed.low) return {std::max(found.low, ratio * found.high), found.high};
  return {found.low, std::min(found.high, found.low / ratio)};
}

}  // namespace prehend::grasp
