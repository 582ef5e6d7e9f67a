#pragma once

#include <string>
#include <vector>

#include "drivers/wire/hand/hand_axes.h"

namespace prehend::drivers::sdh {

/// Of config/robots/sdh2.yaml, in the order of the axes. Which of the fingers 1 and 3 of the
/// vendor's library is which is not published beyond the names that ipa320's schunk_sdh gives them.
inline const std::vector<std::string> kSdh2Axes{
    "pivot",        "finger_1_proximal", "finger_1_distal", "thumb_proximal",
    "thumb_distal", "finger_2_proximal", "finger_2_distal"};

/// A platform's hand as an SDH-2 has its axes, within what the vendor's library allows.
/// `most_current` [A] gives a joint's greatest effort; what the motors give is not published.
/// @throws geometry::InputError as HandAxes.
HandAxes hand_axes(const robot::Platform& platform, const std::vector<std::string>& joints,
                   double most_current);

}  // namespace prehend::drivers::sdh
