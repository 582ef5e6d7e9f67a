#include "prehend/surface/envelope.h"

#include <algorithm>
#include <cmath>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/surface/hull_faces.h"

namespace prehend::surface {
namespace {

/// Empty when the points are flat.
geometry::TriangleMesh hull_of(const std::vector<Eigen::Vector3f>& points) {
  std::vector<Eigen::Vector3d> in_double;
  in_double.reserve(points.size());
  for (const Eigen::Vector3f& p : points) in_double.push_back(p.cast<double>());
  try {
    return geometry::convex_hull(in_double);
  } catch (const geometry::InputError&) {
    return {};
  }
}

}  // namespace

bool cut_at_hull(ScalarGrid& field, const std::vector<Eigen::Vector3f>& points, float margin,
                 float level, float slope) {
  const HullFaces faces(hull_of(points));
  if (faces.empty() || faces.thickness(points) < 1) return false;
  constexpr float kNear = 2;  // nodes to either side in which the field falls off linearly
  const auto lower = [&](int x, int y, int z) {
    float& value = field.at(x, y, z);
    value = std::min(value, level + slope * (margin - faces.distance(Eigen::Vector3f(x, y, z))));
  };
  const int n = field.size().x();
  const auto count = static_cast<std::size_t>(field.size().y());
  std::vector<float> outer_low(count), outer_high(count), inner_low(count), inner_high(count);
  for (int z = 0; z < field.size().z(); ++z) {
    faces.rows(0, static_cast<float>(z), margin + kNear, outer_low, outer_high);
    faces.rows(0, static_cast<float>(z), margin - kNear, inner_low, inner_high);
    for (int y = 0; y < field.size().y(); ++y) {
      for (int x = 0; x < n; ++x) {
        if (x > inner_low[y] && x < inner_high[y]) {
          x = std::min(n, static_cast<int>(std::ceil(inner_high[y]))) - 1;
        } else if (x >= outer_low[y] && x <= outer_high[y]) {
          lower(x, y, z);
        } else {
          field.at(x, y, z) = std::min(field.at(x, y, z), level - slope * kNear);
        }
      }
    }
  }
  return true;
}

}  // namespace prehend::surface
