#include "prehend/shape/neighbors.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>

namespace prehend::shape {
namespace {

using Footprint = std::vector<Eigen::Vector2d>;

/// Axes along the table.
struct TableAxes {
  Eigen::Vector3d up, x, y;

  explicit TableAxes(const Eigen::Vector3d& normal)
      : up(normal), x(up.unitOrthogonal()), y(up.cross(x)) {}

  Eigen::Vector2d along(const Eigen::Vector3f& p_W) const {
    return {x.dot(p_W.cast<double>()), y.dot(p_W.cast<double>())};
  }
  Eigen::Vector3d direction(double angle) const {
    return std::cos(angle) * x + std::sin(angle) * y;
  }
};

/// Some of a shape's points along the table, and the heights between which it was seen [m].
struct Body {
  Footprint seen, predicted;
  double lowest = 0, highest = 0;

  Body(const CompletedShape& shape, const TableAxes& axes) {
    constexpr std::size_t kMost = 500;
    constexpr double kStray = 0.02;  // of the seen points
    const std::size_t stride = 1 + shape.cloud_W.size() / (2 * kMost);
    std::vector<double> heights;
    for (std::size_t i = 0; i < shape.cloud_W.size(); i += stride) {
      const bool is_seen = shape.origin[i] == PointOrigin::kSeen;
      const Eigen::Vector3f& p_W = shape.cloud_W.points[i];
      (is_seen ? seen : predicted).push_back(axes.along(p_W));
      if (is_seen) heights.push_back(axes.up.dot(p_W.cast<double>()));
    }
    if (heights.empty()) return;
    std::sort(heights.begin(), heights.end());
    const auto last = static_cast<double>(heights.size() - 1);
    lowest = heights[static_cast<std::size_t>(kStray * last)];
    highest = heights[static_cast<std::size_t>((1 - kStray) * last)];
  }

  /// Neither was seen to begin where the other ends.
  bool stands_beside(const Body& other) const {
    constexpr double kOverlap = 0.008;  // m
    return std::min(highest, other.highest) - std::max(lowest, other.lowest) > kOverlap;
  }
};

std::vector<double> heights(const Footprint& points, const Eigen::Vector2d& direction) {
  std::vector<double> result;
  result.reserve(points.size());
  for (const Eigen::Vector2d& p : points) result.push_back(direction.dot(p));
  std::sort(result.begin(), result.end());
  return result;
}

/// A plane with `first` under it and `second` over it.
struct Cut {
  double angle = 0;   // rad, of its normal along the table
  double offset = 0;  // m
  double loss = 0;    // m, how far predicted points are on the wrong side: sum of both means
  double gap = 0;     // m, between what was seen of both
};

/// The best of one direction; none when the seen parts lie in each other along it.
std::optional<Cut> best_along(const Body& first, const Body& second, double angle) {
  constexpr double kTolerance = 0.003;  // m, of a seen point
  constexpr double kStray = 0.01;       // of the seen points may be wrong
  constexpr int kOffsets = 16;
  const Eigen::Vector2d direction(std::cos(angle), std::sin(angle));
  const auto first_seen = heights(first.seen, direction);
  const auto second_seen = heights(second.seen, direction);
  const auto rank = [](const std::vector<double>& sorted, double share) {
    return sorted[static_cast<std::size_t>(share * static_cast<double>(sorted.size() - 1))];
  };
  double from = rank(first_seen, 1 - kStray);
  double to = rank(second_seen, kStray);
  const double gap = to - from;
  if (gap < -kTolerance) return std::nullopt;
  if (gap < 0) from = to = 0.5 * (from + to);

  // Mean distance by which points lie beyond `offset`, to the side of `sign`.
  const auto beyond = [&](const Footprint& points, double offset, double sign) {
    double sum = 0;
    for (const Eigen::Vector2d& p : points) {
      sum += std::max(0.0, sign * (direction.dot(p) - offset));
    }
    return points.empty() ? 0 : sum / static_cast<double>(points.size());
  };
  double least = std::numeric_limits<double>::infinity();
  double first_offset = from, last_offset = from;  // of the least loss
  for (int i = 0; i <= kOffsets; ++i) {
    const double offset = from + (to - from) * i / kOffsets;
    const double loss = beyond(first.predicted, offset, 1) + beyond(second.predicted, offset, -1);
    if (loss < least) {
      least = loss;
      first_offset = offset;
    }
    if (loss <= least) last_offset = offset;
  }
  return Cut{angle, 0.5 * (first_offset + last_offset), least, gap};
}

/// None where nothing has to be cut, or nothing can be.
std::optional<Cut> best_cut(const Body& first, const Body& second) {
  constexpr int kDirections = 180;
  std::optional<Cut> best;
  if (first.seen.empty() || second.seen.empty() || !first.stands_beside(second)) return best;
  for (int i = 0; i < kDirections; ++i) {
    const auto cut = best_along(first, second, 2 * std::numbers::pi * i / kDirections);
    if (!cut) continue;
    if (!(cut->loss > 0)) return std::nullopt;  // they are apart
    if (!best || cut->loss < best->loss || (cut->loss == best->loss && cut->gap > best->gap)) {
      best = cut;
    }
  }
  return best;
}

void drop_beyond(CompletedShape& shape, const geometry::Plane& bound_W) {
  const bool colored = !shape.cloud_W.colors.empty();
  const bool has_normals = !shape.cloud_W.normals.empty();
  const bool has_confidence = !shape.point_confidence.empty();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < shape.cloud_W.size(); ++i) {
    const bool is_beyond = bound_W.signed_distance(shape.cloud_W.points[i].cast<double>()) < 0;
    if (is_beyond && shape.origin[i] != PointOrigin::kSeen) continue;
    shape.cloud_W.points[kept] = shape.cloud_W.points[i];
    if (colored) shape.cloud_W.colors[kept] = shape.cloud_W.colors[i];
    if (has_normals) shape.cloud_W.normals[kept] = shape.cloud_W.normals[i];
    shape.origin[kept] = shape.origin[i];
    shape.support[kept] = shape.support[i];
    if (has_confidence) shape.point_confidence[kept] = shape.point_confidence[i];
    ++kept;
  }
  shape.cloud_W.points.resize(kept);
  if (colored) shape.cloud_W.colors.resize(kept);
  if (has_normals) shape.cloud_W.normals.resize(kept);
  shape.origin.resize(kept);
  shape.support.resize(kept);
  if (has_confidence) shape.point_confidence.resize(kept);
  set_region_confidence(shape);
}

void bound(CompletedShape& shape, const geometry::Plane& bound_W) {
  shape.bounds_W.push_back(bound_W);
  drop_beyond(shape, bound_W);
  for (CompletedShape& other : shape.alternatives) drop_beyond(other, bound_W);
  for (CompletedShape& other : shape.other_methods) drop_beyond(other, bound_W);
}

}  // namespace

void keep_apart(const std::vector<CompletedShape*>& shapes, const geometry::Plane& table_W) {
  const TableAxes axes(table_W.normal);
  std::vector<Body> bodies;
  for (const CompletedShape* shape : shapes) bodies.emplace_back(*shape, axes);
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    for (std::size_t j = i + 1; j < shapes.size(); ++j) {
      const auto cut = best_cut(bodies[i], bodies[j]);
      if (!cut) continue;
      const Eigen::Vector3d normal = axes.direction(cut->angle);
      bound(*shapes[i], {-normal, -cut->offset});
      bound(*shapes[j], {normal, cut->offset});
      bodies[i] = Body(*shapes[i], axes);
      bodies[j] = Body(*shapes[j], axes);
    }
  }
}

}  // namespace prehend::shape
