#pragma once

#include <algorithm>
#include <cmath>

namespace prehend::simulation {

/// Signed speed of the next step of length `h` [s] on a trapezoidal profile: at most `max_speed`,
/// changing by at most `acceleration` h, and slow enough to stand at `remaining` (signed distance
/// to the target) with that deceleration: |v| h + v^2 / (2 a) <= |remaining|. All in consistent
/// units.
inline double next_trapezoid_speed(double remaining, double speed, double max_speed,
                                   double acceleration, double h) {
  const double braking = -acceleration * h + std::sqrt(acceleration * acceleration * h * h +
                                                       2 * acceleration * std::abs(remaining));
  const double wanted = std::copysign(std::min(max_speed, braking), remaining);
  return std::clamp(wanted, speed - acceleration * h, speed + acceleration * h);
}

}  // namespace prehend::simulation
