#include "prehend/perception/stereo.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <string>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/perception/disparity_search.h"
#include "prehend/perception/stereo_confidence.h"
#include "prehend/text/require.h"

namespace prehend::perception {
namespace {

using geometry::InputError;

constexpr float kUnknown = std::numeric_limits<float>::quiet_NaN();

void check_options(const StereoOptions& o) {
  const text::Require require{"StereoOptions: "};
  require(std::isfinite(o.min_depth) && o.min_depth > 0, "min_depth must be positive");
  require(std::isfinite(o.max_depth) && o.max_depth > o.min_depth,
          "max_depth must exceed min_depth");
  require(o.block_size % 2 == 1 && o.block_size >= 1 && o.block_size <= 21,
          "block_size must be odd, 1..21");
  require(o.small_step_penalty > 0, "small_step_penalty must be positive");
  require(o.large_step_penalty > o.small_step_penalty && o.large_step_penalty <= 1000,
          "large_step_penalty must exceed small_step_penalty, at most 1000");
  require(o.gradient_cap >= 1 && o.gradient_cap <= 127, "gradient_cap must be 1..127");
  require(o.uniqueness_percent >= 0 && o.uniqueness_percent <= 100,
          "uniqueness_percent must be 0..100");
  require(o.speckle_size >= 0, "speckle_size must not be negative");
  require(o.speckle_range >= 1 && o.speckle_range <= 100, "speckle_range must be 1..100");
  require(o.left_right_tolerance >= -1, "left_right_tolerance must be -1 or more");
  require(o.min_confidence >= 0 && o.min_confidence <= 1, "min_confidence must be 0..1");
  o.subpixel.validate();
}

void check_camera(const geometry::StereoCamera& camera) {
  const geometry::PinholeCamera& c = camera.left;
  const bool good = c.width > 0 && c.height > 0 && std::isfinite(c.fx) && c.fx > 0 &&
                    std::isfinite(c.fy) && c.fy > 0 && std::isfinite(c.cx) && std::isfinite(c.cy) &&
                    std::isfinite(camera.baseline) && camera.baseline > 0;
  if (!good) {
    throw InputError(
        "The stereo camera has a size, focal length or baseline that is not positive "
        "(size " +
            std::to_string(c.width) + " x " + std::to_string(c.height) + ", fx " +
            std::to_string(c.fx) + ", baseline " + std::to_string(camera.baseline) + ")",
        "Calibrate the camera");
  }
}

template <typename T>
void check_images(const geometry::Image<T>& left, const geometry::Image<T>& right,
                  const geometry::PinholeCamera& camera) {
  if (left.width == right.width && left.height == right.height && left.width == camera.width &&
      left.height == camera.height && !left.empty() && left.data.size() == right.data.size()) {
    return;
  }
  const auto size = [](int width, int height) {
    return std::to_string(width) + " x " + std::to_string(height);
  };
  throw InputError("Left image (" + size(left.width, left.height) + "), right image (" +
                       size(right.width, right.height) + ") and calibration (" +
                       size(camera.width, camera.height) + ") differ in size",
                   "Pass a pair and the calibration of the same camera");
}

cv::Ptr<cv::StereoMatcher> matcher_of(const DisparityRange& range, const StereoOptions& o,
                                      int channels) {
  if (o.method == StereoMethod::kBlockMatching) {
    const auto matcher = cv::StereoBM::create(range.count, std::max(o.block_size + 4, 5));
    matcher->setMinDisparity(range.minimum);
    matcher->setPreFilterCap(std::min(o.gradient_cap, 63));
    matcher->setUniquenessRatio(o.uniqueness_percent);
    matcher->setSpeckleWindowSize(o.speckle_size);
    matcher->setSpeckleRange(o.speckle_range);
    matcher->setDisp12MaxDiff(o.left_right_tolerance);
    return matcher;
  }
  const int area = channels * o.block_size * o.block_size;
  return cv::StereoSGBM::create(
      range.minimum, range.count, o.block_size, o.small_step_penalty * area,
      o.large_step_penalty * area, o.left_right_tolerance, o.gradient_cap, o.uniqueness_percent,
      o.speckle_size, o.speckle_range,
      o.eight_directions ? cv::StereoSGBM::MODE_HH : cv::StereoSGBM::MODE_SGBM);
}

DisparityImage match(const cv::Mat& left, const cv::Mat& right, const DisparityRange& range,
                     const StereoOptions& o) {
  // Without padding OpenCV gives no disparity to the left (minimum + count) columns; block
  // matching also needs half a block on every side.
  const int padding = range.minimum + range.count;
  const int margin = o.method == StereoMethod::kBlockMatching ? o.block_size / 2 + 2 : 0;
  cv::Mat padded_left;
  cv::Mat padded_right;
  cv::copyMakeBorder(left, padded_left, margin, margin, padding + margin, margin,
                     cv::BORDER_REPLICATE);
  cv::copyMakeBorder(right, padded_right, margin, margin, padding + margin, margin,
                     cv::BORDER_REPLICATE);
  cv::Mat sixteenths;
  matcher_of(range, o, left.channels())->compute(padded_left, padded_right, sixteenths);

  DisparityImage disparity(left.cols, left.rows, kUnknown);
  const int first_unknown = range.minimum * 16;  // OpenCV marks unknown by (minimum - 1) * 16
  for (int v = 0; v < left.rows; ++v) {
    const auto* row = sixteenths.ptr<std::int16_t>(v + margin) + padding + margin;
    for (int u = 0; u < left.cols; ++u) {
      const float d = static_cast<float>(row[u]) / 16.0F;
      // A match left of the right image is a match with the padding.
      if (row[u] >= first_unknown && d > 0 && d <= static_cast<float>(u)) disparity.at(u, v) = d;
    }
  }
  return disparity;
}

template <typename T>
cv::Mat matrix_of(const geometry::Image<T>& image, int type) {
  return cv::Mat(image.height, image.width, type,
                 const_cast<void*>(static_cast<const void*>(image.data.data())));
}

template <typename T>
DisparityImage disparity_of(const geometry::Image<T>& left, const geometry::Image<T>& right,
                            const geometry::StereoCamera& camera, const StereoOptions& options,
                            int type) {
  const DisparityRange range = disparity_range(camera, options);
  check_images(left, right, camera.left);
  return match(matrix_of(left, type), matrix_of(right, type), range, options);
}

// The right image's disparities: in the mirror it is the left one.
DisparityImage right_disparity_of(const cv::Mat& left, const cv::Mat& right,
                                  const DisparityRange& range, const StereoOptions& options) {
  cv::Mat mirrored_left, mirrored_right;
  cv::flip(left, mirrored_left, 1);
  cv::flip(right, mirrored_right, 1);
  DisparityImage disparity = match(mirrored_right, mirrored_left, range, options);
  for (int v = 0; v < disparity.height; ++v) {
    const auto row = disparity.data.begin() + static_cast<std::ptrdiff_t>(v) * disparity.width;
    std::reverse(row, row + disparity.width);
  }
  return disparity;
}

// A pair as it is matched.
struct Pair {
  GreyImage grey, right_grey;  // `grey` guides filter and confidence
  cv::Mat left, right;         // of the images or of the greys
  DisparityRange range;
};

void set_range(Pair& pair, const GreyImage& left, const GreyImage& right,
               const geometry::StereoCamera& camera, const StereoOptions& options) {
  pair.range = options.narrow_search ? seen_disparity_range(left, right, camera, options)
                                     : disparity_range(camera, options);
}

// Whether the disparities lag, and are moved.
bool is_moved(const StereoOptions& options) {
  return options.method == StereoMethod::kSemiGlobal && !options.eight_directions &&
         options.subpixel.window > 0;
}

DisparityImage match(const Pair& pair, const StereoOptions& options) {
  DisparityImage disparity = match(pair.left, pair.right, pair.range, options);
  if (!is_moved(options)) return disparity;
  return refined_disparity(pair.grey, pair.right_grey, disparity, options.subpixel);
}

// Refers to the images.
Pair pair_of(const geometry::ColorImage& left, const geometry::ColorImage& right,
             const geometry::StereoCamera& camera, const StereoOptions& options) {
  check_options(options);
  check_images(left, right, camera.left);
  const bool colors = options.method == StereoMethod::kSemiGlobal;  // StereoBM knows none
  Pair pair{grey_of(left), {}, {}, {}, {}};
  if (!colors || options.narrow_search || is_moved(options)) pair.right_grey = grey_of(right);
  set_range(pair, pair.grey, pair.right_grey, camera, options);
  pair.left = colors ? matrix_of(left, CV_8UC3) : matrix_of(pair.grey, CV_8UC1);
  pair.right = colors ? matrix_of(right, CV_8UC3) : matrix_of(pair.right_grey, CV_8UC1);
  return pair;
}

StereoMatch match_both(const Pair& pair, const StereoOptions& options) {
  const auto& [grey, right_grey, left, right, range] = pair;
  StereoMatch result;
  result.disparity = match(pair, options);
  DisparityImage right_disparity;
  if (options.match_both_ways) right_disparity = right_disparity_of(left, right, range, options);
  result.confidence = stereo_confidence(grey, result.disparity, right_disparity);
  if (options.filter) {
    result.disparity =
        filtered_disparity(result.disparity, result.confidence, grey, options.filter_options);
    const geometry::Image<float> again = stereo_confidence(grey, result.disparity, {});
    for (std::size_t i = 0; i < again.data.size(); ++i) {
      // What the filter filled in is at best half sure.
      result.confidence.data[i] = std::isnan(result.disparity.data[i])
                                      ? 0.0F
                                      : std::max(result.confidence.data[i], 0.5F * again.data[i]);
    }
  }
  for (std::size_t i = 0; i < result.confidence.data.size(); ++i) {
    if (static_cast<double>(result.confidence.data[i]) >= options.min_confidence) continue;
    result.disparity.data[i] = kUnknown;
    result.confidence.data[i] = 0;
  }
  return result;
}

StereoOptions semi_global(StereoOptions options) {
  options.method = StereoMethod::kSemiGlobal;
  return options;
}

}  // namespace

DisparityRange disparity_range(const geometry::StereoCamera& camera, const StereoOptions& options) {
  check_options(options);
  check_camera(camera);
  const double scale = camera.left.fx * camera.baseline;
  const double largest = scale / options.min_depth;
  const double smallest = scale / options.max_depth;
  if (largest < 1) {
    throw InputError("All depths beyond min_depth = " + std::to_string(options.min_depth) +
                         " m have disparities under one pixel with fx * baseline = " +
                         std::to_string(scale) + " pixel m",
                     "Check the calibration's unit (metres) or lower min_depth");
  }
  DisparityRange range;
  range.minimum = static_cast<int>(std::floor(smallest));
  // More disparities than columns cannot match anything.
  const double last = std::min(std::ceil(largest) + 1, static_cast<double>(camera.left.width));
  if (last <= range.minimum) {
    throw InputError("Depths within max_depth = " + std::to_string(options.max_depth) +
                         " m have disparities beyond the image's width",
                     "Check the calibration's unit (metres) or raise max_depth");
  }
  range.count = (static_cast<int>(last) - range.minimum + 15) / 16 * 16;
  return range;
}

GreyImage grey_of(const geometry::ColorImage& image) {
  GreyImage grey(image.width, image.height);
  for (std::size_t i = 0; i < grey.data.size(); ++i) {
    const geometry::Rgb& c = image.data[i];
    grey.data[i] = static_cast<std::uint8_t>((299 * c[0] + 587 * c[1] + 114 * c[2] + 500) / 1000);
  }
  return grey;
}

StereoMatch match_stereo(const geometry::ColorImage& left, const geometry::ColorImage& right,
                         const geometry::StereoCamera& camera, const StereoOptions& options) {
  return match_both(pair_of(left, right, camera, options), options);
}

StereoMatch match_stereo(const GreyImage& left, const GreyImage& right,
                         const geometry::StereoCamera& camera, const StereoOptions& options) {
  check_options(options);
  check_images(left, right, camera.left);
  Pair pair{left, right, matrix_of(left, CV_8UC1), matrix_of(right, CV_8UC1), {}};
  set_range(pair, left, right, camera, options);
  return match_both(pair, options);
}

DisparityImage stereo_disparity(const geometry::ColorImage& left, const geometry::ColorImage& right,
                                const geometry::StereoCamera& camera,
                                const StereoOptions& options) {
  const Pair pair = pair_of(left, right, camera, options);
  if (options.filter || options.min_confidence > 0) return match_both(pair, options).disparity;
  return match(pair, options);
}

DisparityImage disparity_by_sgbm(const geometry::ColorImage& left,
                                 const geometry::ColorImage& right,
                                 const geometry::StereoCamera& camera,
                                 const StereoOptions& options) {
  return disparity_of(left, right, camera, semi_global(options), CV_8UC3);
}

DisparityImage disparity_by_sgbm(const GreyImage& left, const GreyImage& right,
                                 const geometry::StereoCamera& camera,
                                 const StereoOptions& options) {
  return disparity_of(left, right, camera, semi_global(options), CV_8UC1);
}

geometry::DepthImage depth_from_disparity(const DisparityImage& disparity,
                                          const geometry::StereoCamera& camera) {
  check_camera(camera);
  geometry::DepthImage depth(disparity.width, disparity.height, kUnknown);
  const double scale = camera.left.fx * camera.baseline;
  for (std::size_t i = 0; i < depth.data.size(); ++i) {
    const float d = disparity.data[i];
    if (d > 0) depth.data[i] = static_cast<float>(scale / static_cast<double>(d));
  }
  return depth;
}

geometry::PointCloud cloud_from_depth(const geometry::DepthImage& depth,
                                      const geometry::PinholeCamera& camera,
                                      const geometry::ColorImage& colors) {
  if (depth.width != camera.width || depth.height != camera.height ||
      (!colors.empty() && (colors.width != depth.width || colors.height != depth.height))) {
    throw InputError("Depth image, colour image and camera differ in size",
                     "Pass images of the calibrated camera");
  }
  geometry::PointCloud cloud;
  cloud.width = depth.width;
  cloud.height = depth.height;
  cloud.colors = colors.data;
  cloud.points.assign(depth.data.size(), Eigen::Vector3f::Constant(kUnknown));
  for (int v = 0; v < depth.height; ++v) {
    for (int u = 0; u < depth.width; ++u) {
      const float z = depth.at(u, v);
      if (!std::isfinite(z)) continue;
      cloud.points[static_cast<std::size_t>(v) * depth.width + u] =
          camera.unproject(u, v, static_cast<double>(z)).cast<float>();
    }
  }
  return cloud;
}

geometry::PointCloud cloud_from_disparity(const DisparityImage& disparity,
                                          const geometry::StereoCamera& camera,
                                          const geometry::ColorImage& colors) {
  return cloud_from_depth(depth_from_disparity(disparity, camera), camera.left, colors);
}

geometry::DepthImage depth_of(const geometry::PointCloud& cloud_C) {
  geometry::DepthImage depth(cloud_C.width, cloud_C.height, kUnknown);
  if (depth.data.size() != cloud_C.size()) {
    throw std::invalid_argument("depth_of: the cloud is not organized");
  }
  for (std::size_t i = 0; i < depth.data.size(); ++i) {
    if (geometry::is_finite(cloud_C.points[i])) depth.data[i] = cloud_C.points[i].z();
  }
  return depth;
}

}  // namespace prehend::perception
