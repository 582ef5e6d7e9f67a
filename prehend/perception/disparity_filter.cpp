#include "prehend/perception/disparity_filter.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <stdexcept>
#include <string>
#include <vector>

#include "prehend/text/require.h"

namespace prehend::perception {
namespace {

using geometry::Image;

void check(const DisparityFilterOptions& o) {
  const text::Require require{"DisparityFilterOptions: "};
  require(std::isfinite(o.smoothness) && o.smoothness > 0, "smoothness must be positive");
  require(std::isfinite(o.color_scale) && o.color_scale > 0, "color_scale must be positive");
  require(o.iterations >= 1 && o.iterations <= 10, "iterations must be 1..10");
  require(o.min_support >= 0 && o.min_support <= 1, "min_support must be 0..1");
}

// Smooths two images at once along lines of pixels: (1 + lambda A) u = f for each line, where A is
// the Laplacian of the line weighted by the guide (Thomas' algorithm).
class LineSmoother {
 public:
  LineSmoother(const Image<std::uint8_t>& guide, double color_scale) : guide_(guide) {
    for (int step = 0; step < 256; ++step) {
      tie_[step] = static_cast<float>(std::exp(-step / color_scale));
    }
  }

  // `stride` and `length` of a line that starts at `first`.
  void smooth(Image<float>& a, Image<float>& b, std::size_t first, std::size_t stride,
              std::size_t length, float lambda) {
    upper_.resize(length);
    float before = 0;  // tie to the pixel before
    for (std::size_t k = 0; k < length; ++k) {
      const std::size_t i = first + k * stride;
      const float after =
          k + 1 < length ? lambda * tie_[std::abs(guide_.data[i] - guide_.data[i + stride])] : 0.0F;
      const float eliminated = k > 0 ? before * upper_[k - 1] : 0.0F;
      const float pivot = 1 / (1 + before + after - eliminated);
      upper_[k] = after * pivot;
      const std::size_t previous = k > 0 ? i - stride : i;
      a.data[i] = (a.data[i] + before * (k > 0 ? a.data[previous] : 0.0F)) * pivot;
      b.data[i] = (b.data[i] + before * (k > 0 ? b.data[previous] : 0.0F)) * pivot;
      before = after;
    }
    for (std::size_t k = length - 1; k-- > 0;) {
      const std::size_t i = first + k * stride;
      a.data[i] += upper_[k] * a.data[i + stride];
      b.data[i] += upper_[k] * b.data[i + stride];
    }
  }

 private:
  const Image<std::uint8_t>& guide_;
  std::array<float, 256> tie_{};
  std::vector<float> upper_;
};

}  // namespace

Image<float> filtered_disparity(const Image<float>& disparity, const Image<float>& confidence,
                                const Image<std::uint8_t>& guide,
                                const DisparityFilterOptions& options) {
  check(options);
  const auto same_size = [&](const auto& image) {
    return image.width == disparity.width && image.height == disparity.height &&
           image.data.size() == disparity.data.size();
  };
  if (!same_size(confidence) || !same_size(guide)) {
    throw std::invalid_argument("filtered_disparity: the images differ in size");
  }
  Image<float> weighted = disparity, weight = confidence;
  for (std::size_t i = 0; i < disparity.data.size(); ++i) {
    if (!std::isfinite(disparity.data[i]) || !(confidence.data[i] > 0)) weight.data[i] = 0;
    weighted.data[i] = weight.data[i] > 0 ? weight.data[i] * disparity.data[i] : 0.0F;
  }
  const auto width = static_cast<std::size_t>(disparity.width);
  const auto height = static_cast<std::size_t>(disparity.height);
  LineSmoother smoother(guide, options.color_scale);
  const int n = options.iterations;
  for (int t = 1; t <= n; ++t) {
    // Eq. (24) of the paper: the passes' lambdas fall fourfold, so that no streaks stay.
    const auto lambda = static_cast<float>(1.5 * std::pow(4.0, n - t) / (std::pow(4.0, n) - 1) *
                                           options.smoothness);
    for (std::size_t v = 0; v < height; ++v) {
      smoother.smooth(weighted, weight, v * width, 1, width, lambda);
    }
    for (std::size_t u = 0; u < width; ++u) {
      smoother.smooth(weighted, weight, u, width, height, lambda);
    }
  }
  Image<float> result(disparity.width, disparity.height, std::numeric_limits<float>::quiet_NaN());
  const float least = std::max(static_cast<float>(options.min_support), 1e-6F);
  for (std::size_t i = 0; i < result.data.size(); ++i) {
    if (weight.data[i] >= least) result.data[i] = weighted.data[i] / weight.data[i];
  }
  return result;
}

}  // namespace prehend::perception
