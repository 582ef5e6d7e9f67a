#pragma once

#include <cmath>

#include "drivers/barrett/codec/axes.h"

namespace prehend::drivers::barrett {

/// Turns of a motor, and of the encoder behind a finger's clutch, for one of the joint. libbarrett
/// has 125, 50 and 17.5; pyHand's counts make the first 122.4 and the last 17.6, YARP's (of the
/// BH8-262) the first 127.1.
struct Gearing {
  double finger = 125;
  double encoder = 50;
  double spread = 17.5;
  double counts_per_turn = 4096;  // of a motor and of a joint's encoder; BH8-262: 360

  double counts_per_radian(std::size_t axis) const {
    return counts_per_turn * (axis == kSpread ? spread : finger) / (2 * M_PI);
  }
  double joint_counts_per_radian() const { return counts_per_turn * encoder / (2 * M_PI); }
};

}  // namespace prehend::drivers::barrett
