#include "prehend/surface/size_on_table.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <string>
#include <utility>
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

// The smallest box over a footprint.
struct TableBox {
  Eigen::Vector3d size;    // m, length, width, height
  Eigen::Matrix3d axes_W;  // unit columns, in the order of size; the last one is up
};

TableBox box_on_table(const geometry::TriangleMesh& mesh_W, const geometry::Plane& table_W) {
  const Eigen::Vector3d x = table_W.normal.unitOrthogonal(), y = table_W.normal.cross(x);
  std::vector<Vector2d> footprint;
  double height = 0;
  for (const Eigen::Vector3d& p : mesh_W.vertices) {
    footprint.emplace_back(x.dot(p), y.dot(p));
    height = std::max(height, table_W.signed_distance(p));
  }
  const std::vector<Vector2d> hull = hull_of(std::move(footprint));
  // The smallest rectangle has a side along an edge of the hull (Freeman and Shapira 1975).
  Vector2d best(0, 0), direction(1, 0);
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
    const bool is_longer = sides.x() >= sides.y();
    best = is_longer ? sides : Vector2d(sides.y(), sides.x());
    direction = is_longer ? along : across;
  }
  TableBox box;
  box.size << best, height;
  box.axes_W.col(0) = direction.x() * x + direction.y() * y;
  box.axes_W.col(1) = table_W.normal.cross(box.axes_W.col(0));
  box.axes_W.col(2) = table_W.normal;
  return box;
}

// The standard normal quantile q((1 + c) / 2): a normal error is within that many standard
// deviations with the probability c. By bisection of erf.
double deviations_within(double probability) {
  double low = 0, high = 10;
  for (int i = 0; i < 60; ++i) {
    const double middle = (low + high) / 2;
    (std::erf(middle / std::numbers::sqrt2) < probability ? low : high) = middle;
  }
  return (low + high) / 2;
}

// m^2, of a surface that was seen: of a normal error, whose mean size is known.
double seen_variance(const ObjectModel& model) {
  return std::numbers::pi / 2 * model.seen_deviation * model.seen_deviation;
}

// m^2, of each vertex as an end of an extent.
std::vector<double> end_variances(const ObjectModel& model) {
  constexpr double kRight = 0.005;                // m, see shape/confidence.h
  constexpr double kLeast = 0.01, kMost = 0.999;  // so that the deviation is finite and not 0
  std::vector<double> variances(model.mesh_W.vertices.size(), 4 * seen_variance(model));
  for (std::size_t i = 0; i < model.vertex_origin.size(); ++i) {
    if (model.vertex_origin[i] == SurfaceOrigin::kSeen) continue;
    const double sure = std::clamp<double>(model.vertex_confidence[i], kLeast, kMost);
    const double guess = kRight / deviations_within(sure);
    variances[i] += guess * guess;
  }
  return variances;
}

}  // namespace

Eigen::Vector3d size_on_table(const geometry::TriangleMesh& mesh_W,
                              const geometry::Plane& table_W) {
  return box_on_table(mesh_W, table_W).size;
}

PredictedSize predicted_size(const ObjectModel& model, const geometry::Plane& table_W) {
  constexpr double kEnd = 0.02;  // of the extent
  const TableBox box = box_on_table(model.mesh_W, table_W);
  const std::vector<double> variances = end_variances(model);
  PredictedSize predicted{box.size, Eigen::Vector3d::Zero()};
  for (int axis = 0; axis < 3; ++axis) {
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Eigen::Vector3d& p : model.mesh_W.vertices) {
      low = std::min(low, box.axes_W.col(axis).dot(p));
      high = std::max(high, box.axes_W.col(axis).dot(p));
    }
    const double reach = kEnd * (high - low);
    double low_sum = 0, high_sum = 0;
    int low_count = 0, high_count = 0;
    for (std::size_t i = 0; i < variances.size(); ++i) {
      const double at = box.axes_W.col(axis).dot(model.mesh_W.vertices[i]);
      if (at <= low + reach) low_sum += variances[i], ++low_count;
      if (at >= high - reach) high_sum += variances[i], ++high_count;
    }
    const double low_variance = axis == 2 ? seen_variance(model) : low_sum / low_count;
    predicted.deviation[axis] =
        std::min(std::sqrt(low_variance + high_sum / high_count), box.size[axis] / 2);
  }
  return predicted;
}

std::string size_text(const Eigen::Vector3d& size) {
  char text[80];
  std::snprintf(text, sizeof text, "%.0f x %.0f x %.0f mm", 1e3 * size.x(), 1e3 * size.y(),
                1e3 * size.z());
  return text;
}

std::string size_text(const PredictedSize& predicted) {
  const Eigen::Vector3d size = 1e3 * predicted.size, deviation = 1e3 * predicted.deviation;
  char text[120];
  std::snprintf(text, sizeof text, "%.0f +- %.0f x %.0f +- %.0f x %.0f +- %.0f mm", size.x(),
                deviation.x(), size.y(), deviation.y(), size.z(), deviation.z());
  return text;
}

}  // namespace prehend::surface
