#pragma once

#include <string>
#include <vector>

#include "drivers/barrett/codec/gearing.h"
#include "drivers/barrett/driver/hand_driver.h"
#include "drivers/wire/hand/hand_axes.h"

namespace prehend::drivers::barrett {

/// Of config/robots/bh8.yaml, in the order of the pucks: F1, F2, F3, spread.
inline const std::vector<std::string> kBh8Axes{"finger_1_inner", "finger_2_inner", "finger_3_inner",
                                               "spread"};
/// The pads whose cells the same pucks tell; the spread's that of the palm.
inline const std::vector<std::string> kBh8Pads{"fingertip_1", "fingertip_2", "fingertip_3", "palm"};

/// A platform's hand as a BarrettHand has its axes. `most_torque` (MT of a BH8-280, motor command
/// of a BH8-262) gives a joint's greatest effort; what the motors give is not published.
/// @throws geometry::InputError as HandAxes.
HandAxes hand_axes(const robot::Platform& platform, const std::vector<std::string>& joints,
                   Model model, const Gearing& gearing, double most_torque);

}  // namespace prehend::drivers::barrett
