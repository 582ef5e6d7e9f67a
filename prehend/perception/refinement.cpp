#include "prehend/perception/refinement.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <string>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/perception/disc.h"

namespace prehend::perception {
namespace {

constexpr std::size_t kLeastPoints = 12;
constexpr std::uint64_t kSeed = 1;  // of grabCut's k-means

void check(const RefinementOptions& o) {
  const auto require = [](bool condition, const char* what) {
    if (!condition) throw std::invalid_argument(std::string("RefinementOptions: ") + what);
  };
  require(o.iterations >= 1 && o.iterations <= 20, "iterations must be 1..20");
  require(o.band >= 1 && o.band <= 50, "band must be 1..50");
  require(o.margin > o.band && o.margin <= 1000, "margin must exceed band, at most 1000");
  require(o.least_overlap >= 0 && o.least_overlap <= 1, "least_overlap must be 0..1");
}

cv::Mat view(const geometry::MaskImage& mask) {
  return {mask.height, mask.width, CV_8UC1, const_cast<std::uint8_t*>(mask.data.data())};
}

// The cut's labels of the rectangle `area`; empty when the seeds leave nothing to decide.
cv::Mat seeds(const cv::Mat& mask, const cv::Mat& others, const cv::Rect& area,
              const RefinementOptions& options) {
  cv::Mat inner, outer;
  cv::erode(mask(area), inner, disc(options.band), {-1, -1}, 1, cv::BORDER_CONSTANT, 0);
  cv::dilate(mask(area), outer, disc(options.band));
  cv::Mat labels(area.size(), CV_8UC1, cv::Scalar(cv::GC_BGD));
  labels.setTo(cv::GC_PR_BGD, outer);
  labels.setTo(cv::GC_PR_FGD, mask(area));
  labels.setTo(cv::GC_FGD, inner);
  labels.setTo(cv::GC_BGD, others(area));
  const bool both = cv::countNonZero(labels == cv::GC_BGD) > 0 && cv::countNonZero(inner) > 0;
  return both ? labels : cv::Mat();
}

double overlap(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat both, either;
  cv::bitwise_and(a, b, both);
  cv::bitwise_or(a, b, either);
  return cv::countNonZero(both) / std::max(1.0, static_cast<double>(cv::countNonZero(either)));
}

// The points that project into the mask.
geometry::PointCloud within(const geometry::PointCloud& cloud_W, const SegmentedScene& scene,
                            const cv::Mat& mask) {
  const geometry::RigidTransform X_CW = scene.X_WC.inverse();
  std::vector<int> kept;
  for (std::size_t i = 0; i < cloud_W.size(); ++i) {
    const Eigen::Vector3d p_C = X_CW * cloud_W.points[i].cast<double>();
    if (p_C.z() <= 0) continue;
    const Eigen::Vector2d pixel = scene.camera.project(p_C);
    const auto u = static_cast<int>(std::lround(pixel.x()));
    const auto v = static_cast<int>(std::lround(pixel.y()));
    if (u >= 0 && v >= 0 && u < mask.cols && v < mask.rows && mask.at<std::uint8_t>(v, u) != 0) {
      kept.push_back(static_cast<int>(i));
    }
  }
  return geometry::select(cloud_W, kept);
}

}  // namespace

void refine_masks(SegmentedScene& scene, const geometry::ColorImage& image,
                  const RefinementOptions& options) {
  check(options);
  for (const ObjectHypothesis& object : scene.objects) {
    if (object.mask.width != image.width || object.mask.height != image.height || image.empty()) {
      throw geometry::InputError("The image and the masks differ in size",
                                 "Pass the image that the scene was segmented from");
    }
  }
  const cv::Mat colors(image.height, image.width, CV_8UC3,
                       const_cast<void*>(static_cast<const void*>(image.data.data())));
  cv::Mat all = cv::Mat::zeros(image.height, image.width, CV_8UC1);
  for (const ObjectHypothesis& object : scene.objects) all |= view(object.mask);
  for (ObjectHypothesis& object : scene.objects) {
    const cv::Mat mask = view(object.mask);
    const cv::Mat others = all & ~mask;
    cv::Rect area = cv::boundingRect(mask);
    area -= cv::Point(options.margin, options.margin);
    area += cv::Size(2 * options.margin, 2 * options.margin);
    area &= cv::Rect(0, 0, image.width, image.height);
    if (area.empty()) continue;
    cv::Mat labels = seeds(mask, others, area, options);
    if (labels.empty()) continue;
    cv::Mat background, foreground;
    cv::setRNGSeed(kSeed);
    cv::grabCut(colors(area), labels, cv::Rect(), background, foreground, options.iterations,
                cv::GC_INIT_WITH_MASK);
    cv::Mat refined = cv::Mat::zeros(mask.size(), CV_8UC1);
    refined(area).setTo(255, (labels & 1) == 1);  // GC_FGD and GC_PR_FGD are odd
    if (overlap(mask, refined) < options.least_overlap) continue;
    geometry::PointCloud cloud = within(object.cloud_W, scene, refined);
    if (cloud.size() < kLeastPoints) continue;
    object.cloud_W = std::move(cloud);
    refined.copyTo(mask);
  }
}

}  // namespace prehend::perception
