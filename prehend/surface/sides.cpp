#include <algorithm>
#include <cmath>
#include <iterator>
#include <map>
#include <stdexcept>
#include <vector>

#include "prehend/surface/closing.h"
#include "prehend/surface/outline.h"

namespace prehend::surface {
namespace {

constexpr double kCosine25Degrees = 0.9063078;
constexpr double kLeastGap = 4;  // spacings; shorter edges are bridged by Poisson
constexpr double kUprightSlope = 0.5;
constexpr double kNear = 2;  // spacings

struct Slice {
  std::vector<Eigen::Vector2d> points;
  std::vector<bool> mirrored;  // one per point: on the mirror's far side
};

/// True when the outermost points on one side (sign of y) stand over one another from three slices
/// below `level` to three above it, as far as there are any.
bool is_upright(const std::map<int, Slice>& slices, int level, bool left, double spacing) {
  const auto outermost = [&](const Slice& slice) {
    const auto [least, most] = std::minmax_element(
        slice.points.begin(), slice.points.end(),
        [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.y() < b.y(); });
    return left ? least->y() : most->y();
  };
  const auto below = slices.lower_bound(level - 3);
  const auto above = std::prev(slices.upper_bound(level + 3));
  const int levels = above->first - below->first;
  const double shift = outermost(above->second) - outermost(below->second);
  return std::abs(shift) <= kUprightSlope * std::max(levels, 1) * spacing;
}

bool is_mirrored(shape::PointOrigin origin) {
  return origin == shape::PointOrigin::kMirrored || origin == shape::PointOrigin::kMirroredBoth;
}

/// Which of the points from + k edge / steps, 0 <= k <= steps, have one of `points` within
/// `distance`.
std::vector<bool> near_points(const std::vector<Eigen::Vector2d>& points,
                              const Eigen::Vector2d& from, const Eigen::Vector2d& edge, int steps,
                              double distance) {
  std::vector<bool> near(static_cast<std::size_t>(steps) + 1);
  const double length = edge.norm();
  const Eigen::Vector2d along = edge / length;
  for (const Eigen::Vector2d& q : points) {
    const double beside = along.x() * (q - from).y() - along.y() * (q - from).x();
    const double reach = distance * distance - beside * beside;
    if (!(reach > 0)) continue;
    const double center = along.dot(q - from);
    const double half = std::sqrt(reach);
    const double first = std::max(0.0, std::ceil((center - half) / length * steps));
    const double last = std::min<double>(steps, std::floor((center + half) / length * steps));
    for (double k = first; k <= last; ++k) near[static_cast<std::size_t>(k)] = true;
  }
  return near;
}

}  // namespace

geometry::PointCloud side_points(const shape::CompletedShape& shape, const geometry::Plane& table_W,
                                 double spacing) {
  if (!(spacing > 0)) throw std::invalid_argument("side_points: spacing must be > 0");
  const Eigen::Vector3d up = table_W.normal;
  const Eigen::Vector3d x = shape.symmetry.normal_W;
  const Eigen::Vector3d y = up.cross(x);
  std::map<int, Slice> slices;
  auto last = slices.end();  // neighbours in the cloud are mostly in one slice
  for (std::size_t i = 0; i < shape.cloud_W.size(); ++i) {
    const Eigen::Vector3d p_W = shape.cloud_W.points[i].cast<double>();
    const double height = table_W.signed_distance(p_W);
    if (!(std::abs(height) < 1e6 * spacing)) continue;
    const int level = static_cast<int>(std::floor(height / spacing));
    if (last == slices.end() || last->first != level) last = slices.try_emplace(level).first;
    last->second.points.emplace_back(x.dot(p_W), y.dot(p_W));
    last->second.mirrored.push_back(is_mirrored(shape.origin[i]));
  }

  geometry::PointCloud sides;
  for (const auto& [level, slice] : slices) {
    const double height = (level + 0.5) * spacing;
    const std::vector<int> outline = convex_outline(slice.points);
    for (std::size_t i = 0; i < outline.size(); ++i) {
      const int from = outline[i];
      const int to = outline[(i + 1) % outline.size()];
      const Eigen::Vector2d edge = slice.points[to] - slice.points[from];
      const double length = edge.norm();
      if (length < kLeastGap * spacing || slice.mirrored[from] == slice.mirrored[to] ||
          std::abs(edge.x()) < kCosine25Degrees * length) {
        continue;
      }
      if (!is_upright(slices, level, edge.x() > 0, spacing)) continue;
      const Eigen::Vector2d out = Eigen::Vector2d(edge.y(), -edge.x()) / length;
      const int steps = static_cast<int>(length / spacing);
      const std::vector<bool> near =
          near_points(slice.points, slice.points[from], edge, steps, kNear * spacing);
      for (int step = 1; step < steps; ++step) {
        const Eigen::Vector2d p = slice.points[from] + edge * step / steps;
        if (near[static_cast<std::size_t>(step)]) continue;
        sides.points.push_back(
            (p.x() * x + p.y() * y + (table_W.offset + height) * up).cast<float>());
        sides.normals.push_back((out.x() * x + out.y() * y).cast<float>());
      }
    }
  }
  return sides;
}

}  // namespace prehend::surface
