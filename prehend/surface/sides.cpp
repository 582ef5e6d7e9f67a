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

/// The points of the slices from `level` - `reach` to `level` + `reach`.
Slice thicker(const std::map<int, Slice>& slices, int level, int reach) {
  Slice merged;
  for (auto it = slices.lower_bound(level - reach);
       it != slices.end() && it->first <= level + reach; ++it) {
    const Slice& slice = it->second;
    merged.points.insert(merged.points.end(), slice.points.begin(), slice.points.end());
    merged.mirrored.insert(merged.mirrored.end(), slice.mirrored.begin(), slice.mirrored.end());
  }
  return merged;
}

/// True when the outermost points on one side (sign of y) stand over one another from three slices
/// below `level` to three above it, as far as there are any; `reach` is that of thicker().
bool is_upright(const std::map<int, Slice>& slices, int level, int reach, bool left,
                double spacing) {
  const auto outermost = [&](const Slice& slice) {
    const auto [least, most] = std::minmax_element(
        slice.points.begin(), slice.points.end(),
        [](const Eigen::Vector2d& a, const Eigen::Vector2d& b) { return a.y() < b.y(); });
    return left ? least->y() : most->y();
  };
  const int below = slices.lower_bound(level - 3 - reach)->first;
  const int above = std::prev(slices.upper_bound(level + 3 + reach))->first;
  const int levels = above - below;
  const double shift =
      outermost(thicker(slices, above, reach)) - outermost(thicker(slices, below, reach));
  return std::abs(shift) <= kUprightSlope * std::max(levels, 1) * spacing;
}

/// Distance between neighbouring seen points [m]: of as many, spread evenly over their outline as
/// the camera saw it.
double seen_pitch(const shape::CompletedShape& shape) {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double count = 0;
  for (std::size_t i = 0; i < shape.cloud_W.size(); ++i) {
    if (shape.origin[i] != shape::PointOrigin::kSeen) continue;
    center += shape.cloud_W.points[i].cast<double>();
    count += 1;
  }
  if (count < 3) return 0;
  center /= count;
  const Eigen::Vector3d sight = (center - shape.viewpoint_W).normalized();
  const Eigen::Vector3d right = sight.unitOrthogonal(), down = sight.cross(right);
  std::vector<Eigen::Vector2d> seen;
  for (std::size_t i = 0; i < shape.cloud_W.size(); ++i) {
    if (shape.origin[i] != shape::PointOrigin::kSeen) continue;
    const Eigen::Vector3d p = shape.cloud_W.points[i].cast<double>() - center;
    seen.emplace_back(right.dot(p), down.dot(p));
  }
  const std::vector<int> outline = convex_outline(seen);
  double twice_area = 0;
  for (std::size_t i = 0; i < outline.size(); ++i) {
    const Eigen::Vector2d& a = seen[outline[i]];
    const Eigen::Vector2d& b = seen[outline[(i + 1) % outline.size()]];
    twice_area += a.x() * b.y() - a.y() * b.x();
  }
  return std::sqrt(0.5 * std::abs(twice_area) / count);
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

  // A slice needs a whole row of points, or its outline is a chord through the object.
  constexpr double kRows = 1.5;
  const int reach = std::min(100, static_cast<int>(kRows * seen_pitch(shape) / spacing));
  geometry::PointCloud sides;
  for (const auto& [level, thin] : slices) {
    const Slice slice = thicker(slices, level, reach);
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
      if (!is_upright(slices, level, reach, edge.x() > 0, spacing)) continue;
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
