#pragma once

#include "msgs/camera.pb.h"
#include "prehend/geometry/image.h"

namespace prehend::convert {

/// Fills everything but the header; red-green-blue.
msgs::Image to_message(const geometry::ColorImage& image);
/// Grey becomes red = green = blue. @throws InputError when `data` has another size.
geometry::ColorImage from_message(const msgs::Image& message);

struct ColoredDepth {
  geometry::DepthImage depth;  // m, NaN where unknown
  geometry::ColorImage color;  // of the same size, or empty
};
/// Fills everything but header and generation. Depths are rounded to `unit` [m per count], 0 where
/// they are unknown or beyond 65535 counts. @pre the colour is empty or of the depth's size.
msgs::DepthImage to_message(const ColoredDepth& image, double unit);
/// @throws InputError when `data` has another size, or the unit is not positive and finite.
ColoredDepth from_message(const msgs::DepthImage& message);

}  // namespace prehend::convert
