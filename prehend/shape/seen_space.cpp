#include "prehend/shape/seen_space.h"

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>

#include <opencv2/imgproc.hpp>

namespace prehend::shape {
namespace {

constexpr int kEdge = 2;               // pixels
constexpr double kTableNoise = 0.004;  // m, to either side of the table's plane
constexpr double kFoot = 0.008;        // m: what stands on the table may look like it so far
constexpr float kBeyond = 0.05f;       // m

/// `depth` within the camera's window, whose upper left pixel is (u0, v0) of it and which is framed
/// by kEdge pixels; infinity where unknown.
cv::Mat known_depth(const geometry::DepthImage& depth, int u0, int v0, int width, int height) {
  cv::Mat window(height + 2 * kEdge, width + 2 * kEdge, CV_32F);
  for (int v = 0; v < window.rows; ++v) {
    for (int u = 0; u < window.cols; ++u) {
      const int from_u = u0 + u - kEdge, from_v = v0 + v - kEdge;
      const float z = depth.contains(from_u, from_v) ? depth.at(from_u, from_v) : 0;
      window.at<float>(v, u) = z > 0 ? z : std::numeric_limits<float>::infinity();
    }
  }
  return window;
}

/// Pixels to the nearest one that is known and does not show the table.
cv::Mat distance_to_others(const cv::Mat& depth, const geometry::PinholeCamera& camera,
                           const geometry::Plane& table_C) {
  cv::Mat may_be_table(depth.rows, depth.cols, CV_8U);
  for (int v = 0; v < depth.rows; ++v) {
    for (int u = 0; u < depth.cols; ++u) {
      const auto z = static_cast<double>(depth.at<float>(v, u));
      const bool is_table = std::isinf(z) || std::abs(table_C.signed_distance(camera.unproject(
                                                 u - kEdge, v - kEdge, z))) < kTableNoise;
      may_be_table.at<std::uint8_t>(v, u) = is_table ? 255 : 0;
    }
  }
  cv::Mat distance;
  cv::distanceTransform(may_be_table, distance, cv::DIST_L2, cv::DIST_MASK_PRECISE, CV_32F);
  return distance;
}

}  // namespace

SeenSpace make_seen_space(const geometry::DepthImage& depth, const geometry::PinholeCamera& camera,
                          const geometry::RigidTransform& X_WC, const geometry::Plane& table_W,
                          const std::vector<Eigen::Vector3f>& points_W, int margin) {
  const geometry::RigidTransform X_CW = X_WC.inverse();
  Eigen::AlignedBox2d window;
  for (const Eigen::Vector3f& p_W : points_W) {
    const Eigen::Vector3d p_C = X_CW * p_W.cast<double>();
    if (p_C.z() > 0) window.extend(camera.project(p_C));
  }
  SeenSpace space{camera, X_WC, {}};
  space.camera.width = space.camera.height = 0;
  if (window.isEmpty()) return space;
  const auto clamped = [](double x, int most) {
    return static_cast<int>(std::clamp<double>(std::round(x), 0, most));
  };
  const int u0 = clamped(window.min().x() - margin, camera.width);
  const int v0 = clamped(window.min().y() - margin, camera.height);
  const int u1 = clamped(window.max().x() + margin + 1, camera.width);
  const int v1 = clamped(window.max().y() + margin + 1, camera.height);
  if (u0 >= u1 || v0 >= v1) return space;
  space.camera.width = u1 - u0;
  space.camera.height = v1 - v0;
  space.camera.cx -= u0;
  space.camera.cy -= v0;
  const cv::Mat known = known_depth(depth, u0, v0, space.camera.width, space.camera.height);
  cv::Mat least;
  cv::erode(known, least, cv::Mat::ones(2 * kEdge + 1, 2 * kEdge + 1, CV_8U));
  const Eigen::Vector3d normal_C = X_CW.linear() * table_W.normal;
  const geometry::Plane table_C{normal_C, table_W.offset + normal_C.dot(X_CW.translation())};
  const cv::Mat to_others = distance_to_others(known, space.camera, table_C);
  space.empty_until = geometry::DepthImage(space.camera.width, space.camera.height,
                                           std::numeric_limits<float>::quiet_NaN());
  for (int v = 0; v < space.camera.height; ++v) {
    for (int u = 0; u < space.camera.width; ++u) {
      const float z = known.at<float>(v + kEdge, u + kEdge);
      if (std::isinf(z)) continue;
      const double foot = kEdge + kFoot * std::max(camera.fx, camera.fy) / static_cast<double>(z);
      const bool is_bare = to_others.at<float>(v + kEdge, u + kEdge) > static_cast<float>(foot);
      space.empty_until.at(u, v) = is_bare ? z + kBeyond : least.at<float>(v + kEdge, u + kEdge);
    }
  }
  return space;
}

double depth_in_empty_space(const SeenSpace& space, const Eigen::Vector3d& p_C) {
  constexpr double kUnknown = -std::numeric_limits<double>::infinity();
  if (!(p_C.z() > 0)) return kUnknown;
  const Eigen::Vector2d pixel = space.camera.project(p_C).array() + 0.5;
  if (!(pixel.x() >= 0 && pixel.y() >= 0 && pixel.x() < space.empty_until.width &&
        pixel.y() < space.empty_until.height)) {
    return kUnknown;
  }
  const float until =
      space.empty_until.at(static_cast<int>(pixel.x()), static_cast<int>(pixel.y()));
  return std::isnan(until) ? kUnknown : static_cast<double>(until) - p_C.z();
}

}  // namespace prehend::shape
