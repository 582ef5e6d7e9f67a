#pragma once

#include <opencv2/imgproc.hpp>

namespace prehend::perception {

/// The structuring element that grows and shrinks masks by `radius` pixels, 0 or more.
inline cv::Mat disc(int radius) {
  return cv::getStructuringElement(cv::MORPH_ELLIPSE, {2 * radius + 1, 2 * radius + 1});
}

}  // namespace prehend::perception
