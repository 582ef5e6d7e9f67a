#include "prehend/perception/binning.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "prehend/geometry/errors.h"

namespace prehend::perception {
namespace {

void check_binning(int width, int height, int n) {
  if (n < 1) throw std::invalid_argument("binned: n must be 1 or more");
  if (width >= n && height >= n) return;
  throw geometry::InputError("A picture of " + std::to_string(width) + " x " +
                                 std::to_string(height) + " pixels has none of " +
                                 std::to_string(n) + " x " + std::to_string(n),
                             "Lower the binning");
}

template <class Pixel>
geometry::Image<Pixel> mean_binned(const geometry::Image<Pixel>& image, int n, int type) {
  check_binning(image.width, image.height, n);
  if (n == 1) return image;
  geometry::Image<Pixel> small(image.width / n, image.height / n);
  const cv::Mat all(image.height, image.width, type,
                    const_cast<void*>(static_cast<const void*>(image.data.data())));
  cv::Mat into(small.height, small.width, type, small.data.data());
  cv::resize(all(cv::Rect(0, 0, n * small.width, n * small.height)), into, into.size(), 0, 0,
             cv::INTER_AREA);
  return small;
}

}  // namespace

geometry::ColorImage binned(const geometry::ColorImage& image, int n) {
  return mean_binned(image, n, CV_8UC3);
}

geometry::Image<std::uint8_t> binned(const geometry::Image<std::uint8_t>& image, int n) {
  return mean_binned(image, n, CV_8UC1);
}

geometry::DepthImage binned(const geometry::DepthImage& depth, int n) {
  check_binning(depth.width, depth.height, n);
  if (n == 1) return depth;
  geometry::DepthImage small(depth.width / n, depth.height / n,
                             std::numeric_limits<float>::quiet_NaN());
  std::vector<float> known;
  for (int v = 0; v < small.height; ++v) {
    for (int u = 0; u < small.width; ++u) {
      known.clear();
      for (int k = 0; k < n * n; ++k) {
        const float z = depth.at(n * u + k % n, n * v + k / n);
        if (std::isfinite(z)) known.push_back(z);
      }
      if (2 * static_cast<int>(known.size()) <= n * n) continue;
      const auto median = known.begin() + static_cast<std::ptrdiff_t>((known.size() - 1) / 2);
      std::nth_element(known.begin(), median, known.end());
      small.at(u, v) = *median;
    }
  }
  return small;
}

geometry::PinholeCamera binned(const geometry::PinholeCamera& camera, int n) {
  check_binning(camera.width, camera.height, n);
  geometry::PinholeCamera small = camera;
  small.width /= n;
  small.height /= n;
  small.fx /= n;
  small.fy /= n;
  // Pixel (0, 0) is the centre of its pixel, before and after.
  small.cx = (camera.cx + 0.5) / n - 0.5;
  small.cy = (camera.cy + 0.5) / n - 0.5;
  return small;
}

geometry::StereoCamera binned(const geometry::StereoCamera& camera, int n) {
  return {binned(camera.left, n), camera.baseline};
}

}  // namespace prehend::perception
