#include "prehend/perception/subpixel.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "prehend/text/require.h"

namespace prehend::perception {
namespace {

using DisparityImage = geometry::Image<float>;
using GreyImage = geometry::Image<std::uint8_t>;

constexpr float kLeastKnown = 0.9F;  // of a window's pixels
// By how many rows one-pass matching may lag: some three on a table with little texture.
constexpr float kMostRows = 6;

cv::Mat in_floats(const GreyImage& image) {
  cv::Mat grey;
  cv::Mat(image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.data.data()))
      .convertTo(grey, CV_32F);
  return grey;
}

cv::Mat window_sum(const cv::Mat& image, int window) {
  cv::Mat sum;
  cv::boxFilter(image, sum, CV_32F, {window, window}, {-1, -1}, false, cv::BORDER_CONSTANT);
  return sum;
}

/// A pair, and what it says of disparities.
class Registration {
 public:
  Registration(const GreyImage& left, const GreyImage& right, const SubpixelOptions& options)
      : left_(in_floats(left)), right_(in_floats(right)), options_(options) {
    cv::Sobel(right_, slope_, CV_32F, 1, 0, 3, 1.0 / 8);  // grey levels per pixel
  }

  /// `steps`: by how much each disparity is to grow [pixels]. `misfits`, where asked for: variance
  /// of what the images differ by in the window about each pixel, with these disparities.
  ///   right(u - d - step) ~ warped - step * gradient, which is to be left(u) but for a constant.
  void look(const DisparityImage& disparity, cv::Mat& steps, cv::Mat* misfits) {
    warp(disparity);
    gradient_ = gradient_.mul(known_);
    const cv::Mat error = (warped_ - left_).mul(known_);
    const auto summed = [this](const cv::Mat& image) { return window_sum(image, options_.window); };
    const cv::Mat count = summed(known_), gradients = summed(gradient_), errors = summed(error);
    const cv::Mat slopes = summed(gradient_.mul(gradient_)), both = summed(gradient_.mul(error));
    const auto texture = static_cast<float>(options_.texture);
    steps.create(left_.size(), CV_32F);
    for (int v = 0; v < left_.rows; ++v) {
      const float *n = count.ptr<float>(v), *g = gradients.ptr<float>(v), *e = errors.ptr<float>(v),
                  *gg = slopes.ptr<float>(v), *ge = both.ptr<float>(v);
      auto* step = steps.ptr<float>(v);
      for (int u = 0; u < left_.cols; ++u) {
        const float many = std::max(n[u], 1.0F);
        const float variance = std::max(0.0F, gg[u] - g[u] * g[u] / many);
        step[u] = (ge[u] - g[u] * e[u] / many) / (variance + many * texture);
      }
    }
    if (misfits == nullptr) return;
    const cv::Mat squares = summed(error.mul(error));
    misfits->create(left_.size(), CV_32F);
    for (int v = 0; v < left_.rows; ++v) {
      const float *n = count.ptr<float>(v), *e = errors.ptr<float>(v), *ee = squares.ptr<float>(v);
      auto* misfit = misfits->ptr<float>(v);
      for (int u = 0; u < left_.cols; ++u) {
        const float many = std::max(n[u], 1.0F);
        misfit[u] = (ee[u] - e[u] * e[u] / many) / many;
      }
    }
  }

 private:
  /// The right image and its gradient as the left camera would see them, were these its
  /// disparities.
  void warp(const DisparityImage& disparity) {
    columns_.create(left_.size(), CV_32F);
    rows_.create(left_.size(), CV_32F);
    known_.create(left_.size(), CV_32F);
    const auto last = static_cast<float>(disparity.width - 1);
    for (int v = 0; v < disparity.height; ++v) {
      const float* d = &disparity.at(0, v);
      float *column = columns_.ptr<float>(v), *row = rows_.ptr<float>(v),
            *known = known_.ptr<float>(v);
      for (int u = 0; u < disparity.width; ++u) {
        const float at = static_cast<float>(u) - d[u];
        const bool is_there = at >= 0 && at <= last;  // NaN is not
        column[u] = is_there ? at : 0.0F;
        row[u] = static_cast<float>(v);
        known[u] = is_there ? 1.0F : 0.0F;
      }
    }
    cv::remap(right_, warped_, columns_, rows_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
    cv::remap(slope_, gradient_, columns_, rows_, cv::INTER_LINEAR, cv::BORDER_REPLICATE);
  }

  const cv::Mat left_, right_;
  const SubpixelOptions& options_;
  cv::Mat slope_;                      // of the right image, along its rows
  cv::Mat columns_, rows_;             // where in the right image each pixel is
  cv::Mat warped_, gradient_, known_;  // known: 1 where there is such a place, else 0
};

/// By how much the disparity grows from row to row about each pixel [pixels]; NaN where its window
/// has an edge or too many unknown ones.
std::vector<float> slopes_of(const DisparityImage& disparity, const SubpixelOptions& options) {
  cv::Mat known(disparity.height, disparity.width, CV_32F), values(known.size(), CV_32F),
      weighted(known.size(), CV_32F);
  // Less what is about the middle: single precision is enough for the rest.
  double sum_of_all = 0;
  std::size_t known_of_all = 0;
  for (const float d : disparity.data) {
    if (!std::isfinite(d)) continue;
    sum_of_all += static_cast<double>(d);
    ++known_of_all;
  }
  const auto middle =
      static_cast<float>(sum_of_all / static_cast<double>(std::max<std::size_t>(known_of_all, 1)));
  const auto row_of = [&](int v) { return static_cast<float>(v - disparity.height / 2); };
  for (int v = 0; v < disparity.height; ++v) {
    for (int u = 0; u < disparity.width; ++u) {
      const float d = disparity.at(u, v);
      const bool is_known = std::isfinite(d);
      known.at<float>(v, u) = is_known ? 1.0F : 0.0F;
      values.at<float>(v, u) = is_known ? d - middle : 0.0F;
      weighted.at<float>(v, u) = row_of(v) * values.at<float>(v, u);
    }
  }
  const cv::Mat count = window_sum(known, options.window);
  const cv::Mat sum = window_sum(values, options.window);
  const cv::Mat squares = window_sum(values.mul(values), options.window);
  const cv::Mat moments = window_sum(weighted, options.window);
  const int half = options.window / 2;
  const auto first = [half](int at) { return std::max(at - half, 0); };
  const auto last = [half](int at, int size) { return std::min(at + half, size - 1); };
  const auto most = static_cast<float>(options.edge * options.edge);
  std::vector<float> result(disparity.data.size(), std::numeric_limits<float>::quiet_NaN());
  std::size_t i = 0;
  for (int v = 0; v < disparity.height; ++v) {
    const auto rows = static_cast<float>(last(v, disparity.height) - first(v) + 1);
    const float middle_row = 0.5F * (row_of(first(v)) + row_of(last(v, disparity.height)));
    for (int u = 0; u < disparity.width; ++u, ++i) {
      const auto columns = static_cast<float>(last(u, disparity.width) - first(u) + 1);
      const float n = count.ptr<float>()[i], mean = sum.ptr<float>()[i] / n;
      if (n < kLeastKnown * rows * columns) continue;
      if (!(squares.ptr<float>()[i] / n - mean * mean <= most)) continue;
      // As if all were known; of equally spaced rows the variance is (rows^2 - 1) / 12.
      result[i] = (moments.ptr<float>()[i] / n - middle_row * mean) * 12 / (rows * rows - 1);
    }
  }
  return result;
}

/// What was not moved moves as those in its window do that are of its surface: else faces would
/// have a rim, as wide as half a window, that lags where the rest does not.
void follow_neighbours(const DisparityImage& disparity, const std::vector<bool>& moved,
                       const SubpixelOptions& options, DisparityImage& result) {
  const int half = options.window / 2;
  const auto near = static_cast<float>(options.edge);
  for (int v = 0; v < disparity.height; ++v) {
    for (int u = 0; u < disparity.width; ++u) {
      const float d = disparity.at(u, v);
      const auto pixel = static_cast<std::size_t>(v) * static_cast<std::size_t>(disparity.width) +
                         static_cast<std::size_t>(u);
      if (moved[pixel] || !std::isfinite(d)) continue;
      float sum = 0;
      int count = 0;
      for (int y = std::max(v - half, 0); y <= std::min(v + half, disparity.height - 1); ++y) {
        const auto row = static_cast<std::size_t>(y) * static_cast<std::size_t>(disparity.width);
        for (int x = std::max(u - half, 0); x <= std::min(u + half, disparity.width - 1); ++x) {
          const std::size_t other = row + static_cast<std::size_t>(x);
          if (!moved[other] || !(std::abs(disparity.data[other] - d) <= near)) continue;
          sum += result.data[other] - disparity.data[other];
          ++count;
        }
      }
      if (count > 0) result.data[pixel] = d + sum / static_cast<float>(count);
    }
  }
}

}  // namespace

void SubpixelOptions::validate() const {
  const text::Require require{"SubpixelOptions: "};
  require(window == 0 || (window % 2 == 1 && window >= 3 && window <= 31),
          "window must be odd, 3..31, or 0");
  require(iterations >= 1 && iterations <= 10, "iterations must be 1..10");
  require(std::isfinite(most) && most > 0, "most must be positive");
  require(std::isfinite(texture) && texture > 0, "texture must be positive");
  require(std::isfinite(edge) && edge > 0, "edge must be positive");
}

DisparityImage refined_disparity(const GreyImage& left, const GreyImage& right,
                                 const DisparityImage& disparity, const SubpixelOptions& options) {
  options.validate();
  const auto is_as_large = [&](const auto& image) {
    return image.width == left.width && image.height == left.height;
  };
  if (!is_as_large(right) || !is_as_large(disparity)) {
    throw std::invalid_argument("refined_disparity: the images differ in size");
  }
  if (options.window == 0 || disparity.empty()) return disparity;
  Registration registration(left, right, options);
  DisparityImage result = disparity;
  const auto most = static_cast<float>(options.most);
  cv::Mat steps, before, after;
  for (int pass = 0; pass < options.iterations; ++pass) {
    registration.look(result, steps, pass == 0 ? &before : nullptr);
    for (std::size_t i = 0; i < result.data.size(); ++i) {
      const float first = disparity.data[i];
      if (!std::isfinite(first)) continue;
      result.data[i] =
          std::clamp(result.data[i] + steps.ptr<float>()[i], first - most, first + most);
    }
  }
  registration.look(result, steps, &after);
  const std::vector<float> slopes = slopes_of(disparity, options);
  std::vector<bool> moved(result.data.size());
  for (std::size_t i = 0; i < result.data.size(); ++i) {
    const float farthest = kMostRows * slopes[i], d = disparity.data[i];
    moved[i] = std::isfinite(farthest) && after.ptr<float>()[i] <= before.ptr<float>()[i];
    result.data[i] = moved[i] ? d + std::clamp(result.data[i] - d, std::min(0.0F, farthest),
                                               std::max(0.0F, farthest))
                              : d;
  }
  follow_neighbours(disparity, moved, options, result);
  return result;
}

}  // namespace prehend::perception
