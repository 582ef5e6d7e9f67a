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

// The one of the rank, from 0: by counting, which for so few takes a fraction of sorting them.
std::size_t of_rank(const std::vector<float>& values, std::size_t rank) {
  for (std::size_t k = 0; k < values.size(); ++k) {
    std::size_t less = 0, equal = 0;
    for (const float value : values) {
      less += value < values[k];
      equal += value == values[k];
    }
    if (less <= rank && rank < less + equal) return k;
  }
  throw std::logic_error("of_rank: not so many values");
}

// Of each n x n pixels the one of the median depth [m], of an even number the nearer one; -1 where
// half of them or more have none.
template <class DepthAt>
std::vector<int> median_pixels(int width, int height, int n, const DepthAt& depth_at) {
  std::vector<int> chosen;
  chosen.reserve(static_cast<std::size_t>(width / n) * (height / n));
  std::vector<float> depths;
  std::vector<int> pixels;
  for (int v = 0; v < height / n; ++v) {
    for (int u = 0; u < width / n; ++u) {
      depths.clear();
      pixels.clear();
      for (int row = n * v; row < n * (v + 1); ++row) {
        for (int column = n * u; column < n * (u + 1); ++column) {
          const int pixel = row * width + column;
          const float z = depth_at(pixel);
          if (!std::isfinite(z)) continue;
          depths.push_back(z);
          pixels.push_back(pixel);
        }
      }
      const bool is_known = 2 * static_cast<int>(depths.size()) > n * n;
      chosen.push_back(is_known ? pixels[of_rank(depths, (depths.size() - 1) / 2)] : -1);
    }
  }
  return chosen;
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
  const std::vector<int> chosen =
      median_pixels(depth.width, depth.height, n, [&](int i) { return depth.data[i]; });
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i] >= 0) small.data[i] = depth.data[chosen[i]];
  }
  return small;
}

std::vector<int> binned_points(const geometry::PointCloud& cloud_C, int n) {
  if (!cloud_C.organized()) throw std::invalid_argument("binned: the cloud is no image");
  check_binning(cloud_C.width, cloud_C.height, n);
  return median_pixels(cloud_C.width, cloud_C.height, n, [&](int i) {
    const Eigen::Vector3f& p_C = cloud_C.points[i];
    return geometry::is_finite(p_C) ? p_C.z() : std::numeric_limits<float>::quiet_NaN();
  });
}

int binning_to(const geometry::PointCloud& cloud, int points) {
  if (points <= 0 || !cloud.organized()) return 1;
  const double side = std::sqrt(static_cast<double>(cloud.size()) / points);
  const int n = static_cast<int>(std::lround(side));
  return std::clamp(n, 1, std::min(cloud.width, cloud.height));
}

geometry::PointCloud binned(const geometry::PointCloud& cloud_C, int n) {
  const std::vector<int> chosen = binned_points(cloud_C, n);
  if (n == 1) return cloud_C;
  const Eigen::Vector3f unknown =
      Eigen::Vector3f::Constant(std::numeric_limits<float>::quiet_NaN());
  geometry::PointCloud small;
  small.width = cloud_C.width / n;
  small.height = cloud_C.height / n;
  small.points.assign(chosen.size(), unknown);
  if (!cloud_C.colors.empty()) small.colors.resize(chosen.size());
  if (!cloud_C.normals.empty()) small.normals.assign(chosen.size(), unknown);
  for (std::size_t i = 0; i < chosen.size(); ++i) {
    if (chosen[i] < 0) continue;
    small.points[i] = cloud_C.points[chosen[i]];
    if (!cloud_C.colors.empty()) small.colors[i] = cloud_C.colors[chosen[i]];
    if (!cloud_C.normals.empty()) small.normals[i] = cloud_C.normals[chosen[i]];
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
