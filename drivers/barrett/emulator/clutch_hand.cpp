#include "drivers/barrett/emulator/clutch_hand.h"

#include <algorithm>
#include <cmath>

namespace prehend::drivers::barrett {

HandPlant::Motion ClutchHand::advance(double seconds) {
  constexpr double kFree = 100;  // unit of MT, that an axis takes to move with nothing in its way
  if (seconds <= 0) return motion_;
  motion_.time += seconds;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const Drive& drive = drives_[i];
    const double before = motion_.position[i];
    motion_.velocity[i] = 0;
    motion_.current[i] *= drive.self_locking && !drive.powered ? 1 : 0;
    if (drive.powered) {
      const double way = drive.position - before;
      const double step = std::clamp(way, -drive.speed * seconds, drive.speed * seconds);
      const double wanted = before + (is_stuck_ || drive.current <= 0 ? 0.0 : step);
      motion_.position[i] =
          std::clamp(wanted, std::min(0.0, before), std::max(most_[i], std::min(before, wanted)));
      motion_.velocity[i] = (motion_.position[i] - before) / seconds;
      const bool is_blocked = std::abs(way) > 1e-4 && motion_.position[i] == before;
      const double most = is_blocked ? drive.current : std::min(drive.current, kFree);
      if (way != 0) motion_.current[i] = std::copysign(most, way);
    }
    motion_.joint[i] = std::min(motion_.position[i], std::max(joint_most_[i], 0.0));
  }
  return motion_;
}

}  // namespace prehend::drivers::barrett
