#pragma once

#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "prehend/touch/felt_pad.h"

/// Frames by closed forms, which tests share.
namespace prehend::touch::testing {

/// A pad whose counts are fine enough that rounding does not matter.
inline FeltPad fine_pad(int factor = 1) {
  robot::TactilePadModel model;
  model.rows *= factor;
  model.columns *= factor;
  model.texel_pitch /= factor;
  FeltPad pad = felt_pad(model);
  pad.newton_per_count = 1e-6;
  pad.full_scale = 100'000'000;
  return pad;
}

/// Counts of a pad whose texel at x, y [m] is pressed `depth`(x, y) [m] deep, linear law.
inline std::vector<double> pressed(const FeltPad& pad,
                                   const std::function<double(double, double)>& depth) {
  std::vector<double> counts;
  for (std::size_t i = 0; i < pad.layout.size(); ++i) {
    const double d = std::max(0.0, depth(pad.layout.x[i], pad.layout.y[i]));
    counts.push_back(
        std::round(pad.layout.scale[i] * pad.law.stiffness * d / pad.newton_per_count));
  }
  return counts;
}

/// Depth under a ball of `radius` whose lowest point is at (x0, y0), `deepest` deep. All in m.
inline auto ball(double radius, double deepest, double x0, double y0) {
  return [=](double x, double y) {
    const double r = std::hypot(x - x0, y - y0);
    return r < radius ? deepest - radius + std::sqrt(radius * radius - r * r) : 0.0;
  };
}

}  // namespace prehend::touch::testing
