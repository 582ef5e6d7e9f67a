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

/// How images of the given size [pixels] are rectified: as the calibration says
/// (`calibration.rectification`), unturned when it `is_rectified()`, else by OpenCV's stereoRectify
/// (zero disparity at infinity, only valid pixels).
/// @throws geometry::InputError when the size is not the calibration's, or when the right camera is
/// displaced more vertically than horizontally, or to the left.
StereoRectification rectification(const StereoCalibration& calibration, int width, int height);

/// Turns a raw pair into one whose rows correspond and whose distortion is gone, by
/// rectification() and bilinear remapping. The images are passed through when
/// the calibration needs no rectification. Maps are computed on each call.
/// @throws geometry::InputError when the images' sizes differ from each other, or as
/// rectification().
RectifiedPair rectify(const geometry::ColorImage& left, const geometry::ColorImage& right,
                      const StereoCalibration& calibration);

}  // namespace prehend::perception
