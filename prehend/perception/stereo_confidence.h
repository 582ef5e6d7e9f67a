#pragma once

#include <cstdint>

#include "prehend/geometry/image.h"

namespace prehend::perception {

/// How much each disparity can be relied on, 0..1; 0 where it is NaN. The product of
///  - texture: g^2 / (g^2 + 1), g the root mean square of the horizontal grey-level steps in
///    the `window`; without them any disparity matches;
///  - agreement: share of the window's pixels that are known and within one pixel of this one's
///    disparity;
///  - with `right_disparity` (of the right image, same sign; may be empty): exp(-(l - r)^2 / 2) of
///    the disparities that the two images give the same point, 0.2 where the right one is unknown.
/// It ranks, it is no probability: for share of wrong pixels by confidence see eval_perception.
/// O(pixels). @throws std::invalid_argument for images of different sizes or a window that is not
/// odd and 3..31.
geometry::Image<float> stereo_confidence(const geometry::Image<std::uint8_t>& left,
                                         const geometry::Image<float>& disparity,
                                         const geometry::Image<float>& right_disparity = {},
                                         int window = 9);

}  // namespace prehend::perception
