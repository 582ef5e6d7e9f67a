#include "prehend/perception/stereo_confidence.h"

#include <cmath>
#include <stdexcept>

#include <opencv2/imgproc.hpp>

namespace prehend::perception {
namespace {

using geometry::Image;

constexpr float kTextureNoise = 1;     // grey levels; less is the sensor's noise
constexpr float kUnknownRight = 0.2F;  // factor where the right image has no disparity

// Share of the window round each pixel that is known and has its disparity within one pixel.
Image<float> agreement(const Image<float>& disparity, int window) {
  const int reach = window / 2;
  Image<float> shares(disparity.width, disparity.height, 0.0F);
  for (int v = 0; v < disparity.height; ++v) {
    for (int u = 0; u < disparity.width; ++u) {
      const float own = disparity.at(u, v);
      if (std::isnan(own)) continue;
      int like = 0, all = 0;
      // Every second pixel is enough for a share.
      for (int dv = -reach; dv <= reach; dv += 2) {
        for (int du = -reach; du <= reach; du += 2) {
          if (!disparity.contains(u + du, v + dv)) continue;
          ++all;
          like += std::abs(disparity.at(u + du, v + dv) - own) <= 1;
        }
      }
      shares.at(u, v) = static_cast<float>(like) / static_cast<float>(all);
    }
  }
  return shares;
}

}  // namespace

Image<float> stereo_confidence(const Image<std::uint8_t>& left, const Image<float>& disparity,
                               const Image<float>& right_disparity, int window) {
  if (window < 3 || window > 31 || window % 2 == 0) {
    throw std::invalid_argument("stereo_confidence: window must be odd, 3..31");
  }
  const auto same_size = [&](const auto& image) {
    return image.width == disparity.width && image.height == disparity.height;
  };
  if (!same_size(left) || (!right_disparity.empty() && !same_size(right_disparity))) {
    throw std::invalid_argument("stereo_confidence: the images differ in size");
  }
  Image<float> confidence = agreement(disparity, window);
  if (confidence.empty()) return confidence;

  const cv::Mat grey(left.height, left.width, CV_8UC1, const_cast<std::uint8_t*>(left.data.data()));
  cv::Mat steps, energy;
  const cv::Mat kernel = (cv::Mat_<float>(1, 3) << -0.5F, 0.0F, 0.5F);
  cv::filter2D(grey, steps, CV_32F, kernel, cv::Point(-1, -1), 0, cv::BORDER_REPLICATE);
  cv::boxFilter(steps.mul(steps), energy, CV_32F, cv::Size(window, window), cv::Point(-1, -1), true,
                cv::BORDER_REPLICATE);
  for (int v = 0; v < disparity.height; ++v) {
    for (int u = 0; u < disparity.width; ++u) {
      float& c = confidence.at(u, v);
      if (c == 0) continue;
      const float g = energy.at<float>(v, u);
      c *= g / (g + kTextureNoise * kTextureNoise);
      if (right_disparity.empty()) continue;
      const float d = disparity.at(u, v);
      const int u_right = static_cast<int>(std::lround(static_cast<float>(u) - d));
      const float r =
          right_disparity.contains(u_right, v) ? right_disparity.at(u_right, v) : std::nanf("");
      c *= std::isnan(r) ? kUnknownRight : std::exp(-0.5F * (d - r) * (d - r));
    }
  }
  return confidence;
}

}  // namespace prehend::perception
