#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include <opencv2/imgproc.hpp>

#include "prehend/geometry/errors.h"
#include "prehend/surface/closing.h"
#include "prehend/surface/outline.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using Outline = std::vector<Eigen::Vector2d>;

constexpr double kUpright = 0.2;  // mean of -normal · up below which the lowest slice is upright

/// The cells of the table under the cloud, what they enclose included: what is not convex, as a
/// hammer or wings, has no bottom between its arms. Without points on its top, as of a tall thing
/// seen from the side, the cloud says nothing of that.
class Footprint {
 public:
  Footprint(const Outline& points, const Outline& convex, double spacing)
      : cell_(kCellSpacings * spacing) {
    constexpr double kRing = 3;           // cells: the closing reaches over two
    constexpr double kLeastShare = 0.35;  // of the convex outline that a footprint covers
    Eigen::AlignedBox2d box;
    for (const Eigen::Vector2d& p : points) box.extend(p);
    low_ = box.min() - Eigen::Vector2d::Constant(kRing * cell_);
    const Eigen::Array2d size = ((box.max() - low_) / cell_).array().floor() + 1 + kRing;
    cv::Mat covered(static_cast<int>(size.y()), static_cast<int>(size.x()), CV_8U, cv::Scalar(0));
    for (const Eigen::Vector2d& p : points) covered.at<std::uint8_t>(cell_of(p)) = 255;
    cv::morphologyEx(covered, covered, cv::MORPH_CLOSE,
                     cv::getStructuringElement(cv::MORPH_RECT, {5, 5}));
    outside_ = covered.clone();
    cv::floodFill(outside_, cv::Point(0, 0), cv::Scalar(1));  // 1 where the outside reaches
    double cells = 0, inside = 0;
    for (int v = 0; v < outside_.rows; ++v) {
      for (int u = 0; u < outside_.cols; ++u) {
        if (!prehend::surface::contains(convex, low_ + cell_ * Eigen::Vector2d(u + 0.5, v + 0.5))) {
          continue;
        }
        cells += 1;
        inside += outside_.at<std::uint8_t>(v, u) != 1;
      }
    }
    is_known_ = inside >= kLeastShare * cells;
  }

  bool contains(const Eigen::Vector2d& p) const {
    return !is_known_ || outside_.at<std::uint8_t>(cell_of(p)) != 1;
  }

 private:
  static constexpr double kCellSpacings = 2;

  cv::Point cell_of(const Eigen::Vector2d& p) const {
    const Eigen::Array2d q = ((p - low_) / cell_).array().floor();
    return {static_cast<int>(q.x()), static_cast<int>(q.y())};
  }

  double cell_;
  Eigen::Vector2d low_;
  cv::Mat outside_;
  bool is_known_ = false;
};

}  // namespace

geometry::PointCloud close_bottom(const geometry::PointCloud& cloud, const geometry::Plane& table,
                                  double slice, double spacing) {
  if (cloud.normals.size() != cloud.size() || cloud.empty()) {
    throw InputError("the cloud has no points or no normals", "estimate normals first");
  }
  const Eigen::Vector3d up = table.normal;
  const Eigen::Vector3d x = up.unitOrthogonal();
  const Eigen::Vector3d y = up.cross(x);
  double top = 0;
  double lowest = std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3f& p : cloud.points) {
    const double height = table.signed_distance(p.cast<double>());
    top = std::max(top, height);
    lowest = std::min(lowest, height);
  }
  if (!(top > spacing) || lowest > top) {
    throw InputError("the completed shape does not rise above its table",
                     "check the table's plane and the side its normal points to");
  }
  lowest = std::max(lowest, 0.0);
  // Feet: where the arc that touches the surface in a point of the lowest slice touches the table.
  // With -n · up = s and height h the arc's radius is h / (1 - s).
  Outline feet, all;
  Outline slice_points;
  double downward = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p_W = cloud.points[i].cast<double>();
    const double height = table.signed_distance(p_W);
    all.emplace_back(x.dot(p_W), y.dot(p_W));
    if (height > lowest + slice * (top - lowest)) continue;
    const Eigen::Vector3d n = cloud.normals[i].cast<double>();
    const Eigen::Vector2d out(x.dot(n), y.dot(n));
    const double under = std::clamp(-up.dot(n), 0.0, 0.95);
    const double inwards = std::max(height, 0.0) * std::sqrt(1 - under * under) / (1 - under);
    slice_points.push_back(all.back());
    feet.push_back(slice_points.back());
    if (out.norm() > 0.1) feet.back() -= inwards * out.normalized();
    downward += -up.dot(n);
  }
  const bool upright = downward < kUpright * static_cast<double>(slice_points.size());
  geometry::PointCloud closed = cloud;
  closed.colors.clear();
  const auto corners_of = [](const Outline& points) {
    Outline corners;
    for (const int i : convex_outline(points)) corners.push_back(points[i]);
    return corners;
  };
  Outline outline = corners_of(slice_points);
  if (!upright) {
    // A flipped normal at the limb would send its foot outwards.
    std::erase_if(feet, [&](const Eigen::Vector2d& foot) { return !contains(outline, foot); });
    outline = corners_of(feet);
  }
  if (outline.empty()) return closed;

  const auto add = [&](const Eigen::Vector2d& p, double height, const Eigen::Vector3d& normal) {
    const Eigen::Vector3d p_W = p.x() * x + p.y() * y + (table.offset + height) * up;
    closed.points.push_back(p_W.cast<float>());
    closed.normals.push_back(normal.cast<float>());
  };
  const Footprint footprint(all, outline, spacing);
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : outline) box.extend(p);
  for (double u = box.min().x() + 0.5 * spacing; u < box.max().x(); u += spacing) {
    for (double v = box.min().y() + 0.5 * spacing; v < box.max().y(); v += spacing) {
      if (contains(outline, {u, v}) && footprint.contains({u, v})) add({u, v}, 0, -up);
    }
  }
  if (!upright) return closed;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = outline[i];
    const Eigen::Vector2d side = outline[(i + 1) % outline.size()] - a;
    if (side.norm() < 1e-9 * spacing) continue;
    const Eigen::Vector2d out = Eigen::Vector2d(side.y(), -side.x()).normalized();
    const int steps = std::max(1, static_cast<int>(std::lround(side.norm() / spacing)));
    for (int step = 0; step < steps; ++step) {
      const Eigen::Vector2d p = a + (step + 0.5) / steps * side;
      if (!footprint.contains(p)) continue;
      for (double height = 0.5 * spacing; height < lowest; height += spacing) {
        add(p, height, out.x() * x + out.y() * y);
      }
    }
  }
  return closed;
}

}  // namespace prehend::surface
