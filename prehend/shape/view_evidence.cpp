#include "prehend/shape/view_evidence.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "prehend/geometry/errors.h"

namespace prehend::shape {
namespace {

using geometry::InputError;

cv::Mat as_mat(const geometry::Image<float>& image) {
  return {image.height, image.width, CV_32F, const_cast<float*>(image.data.data())};
}

/// 0 up to half of `tolerance`, 1 from one and a half on. A point that overhangs an edge of the
/// seen top by x appears x sin(e) outside the mask at the far edge and x / cos(e) before the
/// surface at the near one, e the camera's elevation: with half the tolerance outside, both count
/// alike at 45 deg, so that the plane of symmetry is drawn neither towards nor away from the
/// camera.
double ramp(double distance, double tolerance) {
  return std::clamp(distance / tolerance - 0.5, 0.0, 1.0);
}

double interpolated(const geometry::Image<float>& image, double u, double v) {
  const int u0 = std::clamp(static_cast<int>(std::floor(u)), 0, image.width - 1);
  const int v0 = std::clamp(static_cast<int>(std::floor(v)), 0, image.height - 1);
  const int u1 = std::min(u0 + 1, image.width - 1);
  const int v1 = std::min(v0 + 1, image.height - 1);
  const double a = std::clamp(u - u0, 0.0, 1.0);
  const double b = std::clamp(v - v0, 0.0, 1.0);
  return (1 - b) * ((1 - a) * image.at(u0, v0) + a * image.at(u1, v0)) +
         b * ((1 - a) * image.at(u0, v1) + a * image.at(u1, v1));
}

void check_camera(const ObjectView& view) {
  const auto& camera = view.camera;
  if (camera.width <= 0 || camera.height <= 0 || !(camera.fx > 0) || !(camera.fy > 0) ||
      !std::isfinite(camera.fx + camera.fy + camera.cx + camera.cy)) {
    throw InputError("the camera of the view has no valid size or focal length",
                     "give width, height, fx and fy > 0");
  }
  if (view.mask.width != camera.width || view.mask.height != camera.height ||
      view.mask.data.size() != static_cast<std::size_t>(camera.width) * camera.height) {
    throw InputError("the object's mask is " + std::to_string(view.mask.width) + " x " +
                         std::to_string(view.mask.height) + " pixels, the camera's image " +
                         std::to_string(camera.width) + " x " + std::to_string(camera.height),
                     "give a mask of the whole image");
  }
}

}  // namespace

ViewEvidence::ViewEvidence(const ObjectView& view, double depth_tolerance)
    : camera_(view.camera), depth_tolerance_(depth_tolerance) {
  check_camera(view);
  fill_distance(view.mask);
  fill_depth(view);
}

void ViewEvidence::fill_distance(const geometry::MaskImage& mask) {
  cv::Mat outside(mask.height, mask.width, CV_8U);
  std::transform(mask.data.begin(), mask.data.end(), outside.data,
                 [](std::uint8_t pixel) { return pixel ? 0 : 255; });
  if (cv::countNonZero(outside) == mask.width * mask.height) {
    throw InputError("the object's mask is empty", "segment the object again");
  }
  distance_ = geometry::Image<float>(mask.width, mask.height);
  cv::Mat distance = as_mat(distance_);
  cv::distanceTransform(outside, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
}

void ViewEvidence::fill_depth(const ObjectView& view) {
  const float kUnknown = std::numeric_limits<float>::infinity();
  depth_ = geometry::Image<float>(camera_.width, camera_.height, kUnknown);
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  std::size_t inside_mask = 0;
  for (const Eigen::Vector3f& p_W : view.cloud_W.points) {
    const Eigen::Vector3d p_C = X_CW * p_W.cast<double>();
    if (!(p_C.z() > 0)) {
      throw InputError("a seen point lies behind the camera",
                       "check the camera's pose; its optical frame looks along +z");
    }
    const Eigen::Vector2d pixel = camera_.project(p_C);
    if (!(pixel.cwiseAbs().maxCoeff() < 1e6)) continue;
    const int u = static_cast<int>(std::lround(pixel.x()));
    const int v = static_cast<int>(std::lround(pixel.y()));
    if (!depth_.contains(u, v)) continue;
    depth_.at(u, v) = std::min(depth_.at(u, v), static_cast<float>(p_C.z()));
    inside_mask += distance_.at(u, v) <= 1.5f;
  }
  if (2 * inside_mask < view.cloud_W.size()) {
    throw InputError("only " + std::to_string(inside_mask) + " of " +
                         std::to_string(view.cloud_W.size()) +
                         " seen points project into the object's mask",
                     "check that mask, camera and camera pose belong to the cloud");
  }

  // A cloud may be coarser than the image: a pixel without a point takes the nearest one's depth.
  cv::Mat unknown(camera_.height, camera_.width, CV_8U);
  std::transform(depth_.data.begin(), depth_.data.end(), unknown.data,
                 [&](float depth) { return depth == kUnknown ? 255 : 0; });
  cv::Mat pixels_away;
  cv::Mat labels;
  cv::distanceTransform(unknown, pixels_away, labels, cv::DIST_L2, cv::DIST_MASK_5,
                        cv::DIST_LABEL_PIXEL);
  std::vector<float> depth_of_label(depth_.data.size() + 1, kUnknown);
  for (std::size_t i = 0; i < depth_.data.size(); ++i) {
    if (depth_.data[i] != kUnknown) {
      depth_of_label[labels.at<int>(static_cast<int>(i))] = depth_.data[i];
    }
  }
  for (std::size_t i = 0; i < depth_.data.size(); ++i) {
    depth_.data[i] = depth_of_label[labels.at<int>(static_cast<int>(i))];
  }
}

PointEvidence ViewEvidence::about(const Eigen::Vector3d& p_C) const {
  PointEvidence evidence;
  if (!(p_C.z() > 1e-9)) return evidence;
  const Eigen::Vector2d pixel = camera_.project(p_C);
  if (!(pixel.x() > -0.5 && pixel.y() > -0.5 && pixel.x() < camera_.width - 0.5 &&
        pixel.y() < camera_.height - 0.5)) {
    return evidence;
  }
  // Pixels are squares: half a pixel from the centre of the mask's last one is still within.
  const double away = interpolated(distance_, pixel.x(), pixel.y()) - 0.5;
  if (away > 0) {
    evidence.outside = away * p_C.z() / (0.5 * (camera_.fx + camera_.fy));
    evidence.contradicted = ramp(evidence.outside, 0.5 * depth_tolerance_);
    return evidence;
  }
  const int u = std::clamp(static_cast<int>(std::lround(pixel.x())), 0, camera_.width - 1);
  const int v = std::clamp(static_cast<int>(std::lround(pixel.y())), 0, camera_.height - 1);
  const double before = depth_.at(u, v) - p_C.z();
  evidence.in_front = std::max(0.0, before - depth_tolerance_);
  evidence.contradicted = ramp(before, depth_tolerance_);
  evidence.coincident = std::max(0.0, 1 - std::abs(before) / depth_tolerance_);
  return evidence;
}

}  // namespace prehend::shape
