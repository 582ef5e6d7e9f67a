#pragma once

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/image.h"
#include "prehend/perception/calibration.h"

namespace prehend::perception {

struct RectifiedPair {
  geometry::ColorImage left;
  geometry::ColorImage right;
  geometry::StereoCamera camera;
};

/// Turns a raw pair into one whose rows correspond and whose distortion is gone (OpenCV's
/// stereoRectify, zero disparity at infinity, only valid pixels; bilinear remapping). The images
/// are passed through when `calibration.is_rectified()`. Maps are computed on each call.
/// @throws geometry::InputError when the images' sizes differ from each other or the calibration,
/// or when the right camera is displaced more vertically than horizontally, or to the left.
RectifiedPair rectify(const geometry::ColorImage& left, const geometry::ColorImage& right,
                      const StereoCalibration& calibration);

}  // namespace prehend::perception
