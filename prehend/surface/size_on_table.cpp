#include "prehend/surface/size_on_table.h"

#include <algorithm>
#include <cstdio>
#include <limits>
#include <string>
#include <vector>

namespace prehend::surface {
namespace {

using Eigen::Vector2d;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

// Convex hull, counter-clockwise, by Andrew's monotone chain.
std::vector<Vector2d> hull_of(std::vector<Vector2d> points) {
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  std::vector<Vector2d> hull;
  for (int side = 0; side < 2; ++side) {
    const std::size_t start = hull.size();
    for (const Vector2d& p : points) {
      while (hull.size() >= start + 2 &&
             cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0) {
        hull.pop_back();
      }
      hull.push_back(p);
    }
    hull.pop_back();
    std::reverse(points.begin(), points.end());
  }
  return hull;
}

}  // namespace

Eigen::Vector3d size_on_table(const geometry::TriangleMesh& mesh_W,
                              const geometry::Plane& table_W) {
  const Eigen::Vector3d x = table_W.normal.unitOrthogonal(), y = table_W.normal.cross(x);
  std::vector<Vector2d> footprint;
  double height = 0;
  for (const Eigen::Vector3d& p : mesh_W.vertices) {
    footprint.emplace_back(x.dot(p), y.dot(p));
    height = std::max(height, table_W.signed_distance(p));
  }
  const std::vector<Vector2d> hull = hull_of(std::move(footprint));
  // The smallest rectangle has a side along an edge of the hull (Freeman and Shapira 1975).
  Vector2d best(0, 0);
  double least = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d along = (hull[(i + 1) % hull.size()] - hull[i]).normalized();
    const Vector2d across(-along.y(), along.x());
    if (!along.allFinite()) continue;
    Vector2d low = Vector2d::Constant(std::numeric_limits<double>::infinity()), high = -low;
    for (const Vector2d& p : hull) {
      const Vector2d q(along.dot(p), across.dot(p));
      low = low.cwiseMin(q);
      high = high.cwiseMax(q);
    }
    const Vector2d sides = high - low;
    if (sides.prod() >= least) continue;
    least = sides.prod();
    best = sides;
  }
  return {best.maxCoeff(), best.minCoeff(), height};
}

std::string size_text(const Eigen::Vector3d& size) {
  char text[80];
  std::snprintf(text, sizeof text, "%.0f x %.0f x %.0f mm", 1e3 * size.x(), 1e3 * size.y(),
                1e3 * size.z());
  return text;
}

}  // namespace prehend::surface
