#include "eval/stereo_accuracy.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>
#include <limits>
#include <numeric>
#include <stdexcept>

#include <opencv2/calib3d.hpp>

#include "prehend/perception/image_files.h"

namespace prehend::eval {
namespace {

using perception::DisparityImage;
using perception::StereoOptions;

constexpr float kUnknownDisparity = std::numeric_limits<float>::quiet_NaN();
constexpr double kThresholds[] = {1, 2, 4};  // pixels

// OpenCV alone on grey images, its defaults but for the range and a window of `block`.
DisparityImage plain_opencv(const StereoTruth& truth, bool semi_global) {
  const perception::GreyImage left = perception::grey_of(truth.left);
  const perception::GreyImage right = perception::grey_of(truth.right);
  const auto view = [](const perception::GreyImage& image) {
    return cv::Mat(image.height, image.width, CV_8UC1,
                   const_cast<std::uint8_t*>(image.data.data()));
  };
  const int count = (static_cast<int>(std::ceil(truth.largest)) + 16) / 16 * 16;
  cv::Ptr<cv::StereoMatcher> matcher;
  if (semi_global) {
    matcher = cv::StereoSGBM::create(0, count, 5, 8 * 25, 32 * 25);
  } else {
    matcher = cv::StereoBM::create(count, 9);
  }
  cv::Mat sixteenths;
  matcher->compute(view(left), view(right), sixteenths);
  DisparityImage disparity(left.width, left.height, kUnknownDisparity);
  for (int v = 0; v < left.height; ++v) {
    for (int u = 0; u < left.width; ++u) {
      const int value = sixteenths.at<std::int16_t>(v, u);
      if (value > 0) disparity.at(u, v) = static_cast<float>(value) / 16;
    }
  }
  return disparity;
}

}  // namespace

DisparityErrors disparity_errors(const DisparityImage& found, const DisparityImage& truth,
                                 const geometry::Image<float>& confidence) {
  if (found.data.size() != truth.data.size() || found.width != truth.width ||
      (!confidence.empty() && confidence.data.size() != found.data.size())) {
    throw std::invalid_argument("disparity_errors: the images differ in size");
  }
  DisparityErrors errors;
  double known = 0;
  std::vector<std::size_t> matched;
  for (std::size_t i = 0; i < truth.data.size(); ++i) {
    if (std::isnan(truth.data[i])) continue;
    known += 1;
    if (!std::isnan(found.data[i])) matched.push_back(i);
  }
  if (known == 0 || matched.empty()) {
    errors.bad_or_missing.fill(known > 0 ? 1 : 0);
    return errors;
  }
  const auto error_at = [&](std::size_t i) {
    return std::abs(static_cast<double>(found.data[i]) - static_cast<double>(truth.data[i]));
  };
  const auto share_bad = [&](std::size_t first, std::size_t last, double threshold) {
    double bad = 0;
    for (std::size_t k = first; k < last; ++k) bad += error_at(matched[k]) > threshold;
    return last > first ? bad / static_cast<double>(last - first) : 0.0;
  };
  const auto all = static_cast<double>(matched.size());
  errors.density = all / known;
  for (int t = 0; t < 3; ++t) {
    errors.bad[t] = share_bad(0, matched.size(), kThresholds[t]);
    errors.bad_or_missing[t] = (errors.bad[t] * all + known - all) / known;
  }
  if (!confidence.empty()) {
    std::stable_sort(matched.begin(), matched.end(), [&](std::size_t a, std::size_t b) {
      return confidence.data[a] > confidence.data[b];
    });
  }
  errors.sure_bad = share_bad(0, matched.size() / 2, 1);
  errors.unsure_bad = share_bad(matched.size() / 2, matched.size(), 1);
  return errors;
}

StereoTruth read_middlebury_2003(const std::filesystem::path& folder) {
  StereoTruth truth;
  truth.left = perception::read_color_image(folder / "im2.png");
  truth.right = perception::read_color_image(folder / "im6.png");
  const geometry::ColorImage coded = perception::read_color_image(folder / "disp2.png");
  truth.disparity = DisparityImage(coded.width, coded.height, kUnknownDisparity);
  truth.smallest = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < coded.data.size(); ++i) {
    if (coded.data[i][0] == 0) continue;
    const double value = coded.data[i][0] / 4.0;
    truth.disparity.data[i] = static_cast<float>(value);
    truth.smallest = std::min(truth.smallest, value);
    truth.largest = std::max(truth.largest, value);
  }
  return truth;
}

std::vector<StereoRun> compare_stereo_methods(const StereoTruth& truth) {
  // Disparity = 1 / depth with this camera.
  const geometry::StereoCamera camera{{truth.left.width, truth.left.height, 100, 100, 0, 0}, 0.01};
  StereoOptions base;
  base.min_depth = 1 / (truth.largest + 1);
  base.max_depth = 1 / std::max(truth.smallest - 1, 0.5);
  const auto with = [&](const std::function<void(StereoOptions&)>& change) {
    StereoOptions options = base;
    change(options);
    return options;
  };
  std::vector<StereoRun> runs;
  const auto add = [&](const std::string& method, const auto& match) {
    const auto start = std::chrono::steady_clock::now();
    const perception::StereoMatch result = match();
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start;
    runs.push_back({method, disparity_errors(result.disparity, truth.disparity, result.confidence),
                    spent.count()});
  };
  add("OpenCV StereoBM", [&] { return perception::StereoMatch{plain_opencv(truth, false), {}}; });
  add("OpenCV StereoSGBM", [&] { return perception::StereoMatch{plain_opencv(truth, true), {}}; });
  const std::pair<const char*, StereoOptions> own[] = {
      {"block matching",
       with([](StereoOptions& o) { o.method = perception::StereoMethod::kBlockMatching; })},
      {"block matching, narrowed", with([](StereoOptions& o) {
         o.method = perception::StereoMethod::kBlockMatching;
         o.narrow_search = true;
       })},
      {"semi-global", base},
      {"semi-global, narrowed", with([](StereoOptions& o) { o.narrow_search = true; })},
      {"semi-global, both ways", with([](StereoOptions& o) { o.match_both_ways = true; })},
      {"semi-global, 8 directions", with([](StereoOptions& o) { o.eight_directions = true; })},
      {"semi-global, filtered", with([](StereoOptions& o) { o.filter = true; })},
      {"semi-global, both ways, filtered", with([](StereoOptions& o) {
         o.match_both_ways = true;
         o.filter = true;
       })},
      {"semi-global, confidence >= 0.5", with([](StereoOptions& o) { o.min_confidence = 0.5; })}};
  for (const auto& [name, options] : own) {
    add(name, [&, &chosen = options] {
      return perception::match_stereo(truth.left, truth.right, camera, chosen);
    });
  }
  return runs;
}

}  // namespace prehend::eval
