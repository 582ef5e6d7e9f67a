#pragma once

#include <cstdint>
#include <vector>

#include "drivers/kuka_rsi/driver/limits.h"
#include "prehend/simulation/arm_drive.h"

namespace prehend::drivers::kuka_rsi {

/// A trajectory as set points, one for each of the controller's cycles.
struct Motion {
  std::uint64_t ticket = 0;      // whose it is
  std::vector<Axes> set_points;  // rad; the first one a cycle after the arm stood
  double contact_force = 0;      // N, of the wrist, that stops it; 0: not minded
  Axes tolerance{};              // rad, off the path, of each axis
};

/// Interpolates `trajectory` to cycles [s] for an arm whose set point stands at `start`. What its
/// first point is off fades out (6s^5 - 15s^4 + 10s^3) within limits, as robots' loops let it. Each
/// set point is held to `limits`, and so is the tool along the braking that could begin there.
/// @throws std::invalid_argument in words: when, which joint, what it breaks, the mend.
std::vector<Axes> set_points_of(const simulation::ArmTrajectory& trajectory, const Axes& start,
                                const Axes& reference, const Limits& limits, double cycle);

}  // namespace prehend::drivers::kuka_rsi
