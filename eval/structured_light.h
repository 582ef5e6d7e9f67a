#pragma once

#include <cstdint>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"

namespace prehend::eval {

/// What a structured-light camera makes of true depths. Standard deviation and steps of depth grow
/// with its square (Khoshelham and Oude Elberink 2012, "Accuracy and Resolution of Kinect Depth
/// Data", Sensors 12(2), equations 10 and 11: 1.43 mm and 2.7 mm at 1 m); steps in depth bleed over
/// some pixels and leave gaps on the shadowed side; what is seen at a grazing angle, and what
/// swallows or mirrors light, gives nothing.
struct StructuredLightNoise {
  double deviation = 1.43e-3;  // m at 1 m
  double step = 2.7e-3;        // m at 1 m
  int bleed = 2;               // pixels that an edge wanders at most
  double grazing = 0.15;       // least cosine between surface normal and ray
  double missing = 0;          // part of the pixels labelled 0 without depth, in blotches
  std::uint32_t seed = 1;
};

/// @param depth [m], true, NaN where nothing is hit. @param labels of the same size.
geometry::DepthImage structured_light(const geometry::DepthImage& depth,
                                      const geometry::Image<std::int16_t>& labels,
                                      const geometry::PinholeCamera& camera,
                                      const StructuredLightNoise& noise);

}  // namespace prehend::eval
