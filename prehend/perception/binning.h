#pragma once

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"

// Pictures with fewer pixels, and the camera that would have taken them: n x n pixels become one.
// Columns and rows that fill no whole pixel are left out at the right and below. n = 1 changes
// nothing. All throw std::invalid_argument unless n is 1 or more, and geometry::InputError when
// nothing of the picture is left.
namespace prehend::perception {

/// Mean of the n x n pixels, which is what a sensor with larger pixels would see.
geometry::ColorImage binned(const geometry::ColorImage& image, int n);
geometry::Image<std::uint8_t> binned(const geometry::Image<std::uint8_t>& image, int n);

/// One of the n x n depths [m]: their median, of an even number the nearer one, so that no depth
/// comes out between a body and what is behind it. NaN where half of them or more are unknown.
geometry::DepthImage binned(const geometry::DepthImage& depth, int n);

/// A pixel covers n x n of before: focal length, principal point and size change, what is seen of
/// a pixel's direction does not.
geometry::PinholeCamera binned(const geometry::PinholeCamera& camera, int n);
geometry::StereoCamera binned(const geometry::StereoCamera& camera, int n);

}  // namespace prehend::perception
