#include "prehend/perception/disparity_search.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "prehend/perception/binning.h"

namespace prehend::perception {
namespace {

constexpr int kCoarse = 4;             // pixels of a side that are one in the small pair
constexpr int kFewDisparities = 32;    // not worth a match of their own
constexpr double kLeastMatched = 0.1;  // of the small pair's pixels

StereoOptions coarse_options(StereoOptions options) {
  options.method = StereoMethod::kSemiGlobal;
  options.eight_directions = false;
  options.subpixel.window = 0;
  options.speckle_size /= kCoarse * kCoarse;
  // A step that tears a patch apart when small does so when large, not the other way round.
  options.speckle_range = std::max(options.speckle_range / kCoarse, 1);
  return options;
}

}  // namespace

DisparityRange seen_disparity_range(const GreyImage& left, const GreyImage& right,
                                    const geometry::StereoCamera& camera,
                                    const StereoOptions& options) {
  const DisparityRange all = disparity_range(camera, options);
  if (all.count <= kFewDisparities) return all;
  const DisparityImage coarse = disparity_by_sgbm(binned(left, kCoarse), binned(right, kCoarse),
                                                  binned(camera, kCoarse), coarse_options(options));
  // The small pair's range is one of sixteens, too, and may reach beyond what is asked for.
  const int end = all.minimum + all.count - 1;
  const auto farthest = static_cast<float>(end + kSearchMargin) / kCoarse;
  float least = 0, most = 0;
  std::size_t matched = 0;
  for (const float d : coarse.data) {
    if (std::isnan(d) || d > farthest) continue;
    least = matched == 0 ? d : std::min(least, d);
    most = std::max(most, d);
    matched += 1;
  }
  if (static_cast<double>(matched) < kLeastMatched * static_cast<double>(coarse.data.size())) {
    return all;
  }
  const int first =
      std::max(static_cast<int>(std::floor(kCoarse * least)) - kSearchMargin, all.minimum);
  const int last = std::min(static_cast<int>(std::ceil(kCoarse * most)) + kSearchMargin, end);
  return {first, std::min((last - first) / 16 * 16 + 16, all.count)};
}

}  // namespace prehend::perception
