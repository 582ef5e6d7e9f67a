#pragma once

#include <algorithm>
#include <cmath>

namespace prehend::simulation {

/// The speed that still stops within `remaining` >= 0: v h + v^2 / (2 a) = remaining.
inline double stopping_speed(double remaining, double acceleration, double h) {
  return -acceleration * h +
         std::sqrt(acceleration * acceleration * h * h + 2 * acceleration * remaining);
}

/// Signed speed of the next step of length `h` [s] on a trapezoidal profile: at most `max_speed`,
/// changing by at most `acceleration` h, and slow enough to stand at `remaining` (signed distance
/// to the target) with that deceleration (stopping_speed). All in consistent units.
inline double next_trapezoid_speed(double remaining, double speed, double max_speed,
                                   double acceleration, double h) {
  const double braking = stopping_speed(std::abs(remaining), acceleration, h);
  const double wanted = std::copysign(std::min(max_speed, braking), remaining);
  return std::clamp(wanted, speed - acceleration * h, speed + acceleration * h);
}

}  // namespace prehend::simulation
