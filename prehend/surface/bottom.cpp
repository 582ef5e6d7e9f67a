#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "prehend/geometry/errors.h"
#include "prehend/surface/closing.h"
#include "prehend/surface/outline.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using Outline = std::vector<Eigen::Vector2d>;

constexpr double kUpright = 0.2;  // mean of -normal · up below which the lowest slice is upright

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
  Outline feet;
  Outline slice_points;
  double downward = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p_W = cloud.points[i].cast<double>();
    const double height = table.signed_distance(p_W);
    if (height > lowest + slice * (top - lowest)) continue;
    const Eigen::Vector3d n = cloud.normals[i].cast<double>();
    const Eigen::Vector2d out(x.dot(n), y.dot(n));
    const double under = std::clamp(-up.dot(n), 0.0, 0.95);
    const double inwards = std::max(height, 0.0) * std::sqrt(1 - under * under) / (1 - under);
    slice_points.emplace_back(x.dot(p_W), y.dot(p_W));
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
  Eigen::AlignedBox2d box;
  for (const Eigen::Vector2d& p : outline) box.extend(p);
  for (double u = box.min().x() + 0.5 * spacing; u < box.max().x(); u += spacing) {
    for (double v = box.min().y() + 0.5 * spacing; v < box.max().y(); v += spacing) {
      if (contains(outline, {u, v})) add({u, v}, 0, -up);
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
      for (double height = 0.5 * spacing; height < lowest; height += spacing) {
        add(a + (step + 0.5) / steps * side, height, out.x() * x + out.y() * y);
      }
    }
  }
  return closed;
}

}  // namespace prehend::surface
