#include "prehend/surface/envelope.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {
namespace {

/// Outside where normal · p > offset.
struct Face {
  Eigen::Vector3f normal;
  float offset;
};

std::vector<Face> hull_faces(const std::vector<Eigen::Vector3f>& points) {
  std::vector<Eigen::Vector3d> in_double;
  in_double.reserve(points.size());
  for (const Eigen::Vector3f& p : points) in_double.push_back(p.cast<double>());
  geometry::TriangleMesh hull;
  try {
    hull = geometry::convex_hull(in_double);
  } catch (const geometry::InputError&) {
    return {};  // flat
  }
  std::vector<Face> faces;
  for (const Eigen::Vector3i& t : hull.triangles) {
    const Eigen::Vector3d& a = hull.vertices[t.x()];
    const Eigen::Vector3d n = (hull.vertices[t.y()] - a).cross(hull.vertices[t.z()] - a);
    if (!(n.norm() > 1e-6)) continue;
    const Eigen::Vector3d unit = n.normalized();
    faces.push_back({unit.cast<float>(), static_cast<float>(unit.dot(a))});
  }
  return faces;
}

float thickness(const std::vector<Face>& faces, const std::vector<Eigen::Vector3f>& points) {
  float least = std::numeric_limits<float>::infinity();
  for (const Face& face : faces) {
    float deepest = 0;
    for (const Eigen::Vector3f& p : points) {
      deepest = std::max(deepest, face.offset - face.normal.dot(p));
    }
    least = std::min(least, deepest);
  }
  return least;
}

/// The part of a row along x, from (0, y, z), within all faces moved outward by `shift`.
std::pair<float, float> row_within(const std::vector<Face>& faces, float y, float z, float shift) {
  float low = -std::numeric_limits<float>::infinity();
  float high = std::numeric_limits<float>::infinity();
  for (const Face& face : faces) {
    const float room = face.offset + shift - face.normal.y() * y - face.normal.z() * z;
    if (std::abs(face.normal.x()) < 1e-6f) {
      if (room < 0) return {0, -1};
    } else if (face.normal.x() > 0) {
      high = std::min(high, room / face.normal.x());
    } else {
      low = std::max(low, room / face.normal.x());
    }
  }
  return {low, high};
}

}  // namespace

bool cut_at_hull(ScalarGrid& field, const std::vector<Eigen::Vector3f>& points, float margin,
                 float level, float slope) {
  const std::vector<Face> faces = hull_faces(points);
  if (faces.empty() || thickness(faces, points) < 1) return false;
  constexpr float kNear = 2;  // nodes to either side in which the field falls off linearly
  const auto lower = [&](int x, int y, int z) {
    float out = -std::numeric_limits<float>::infinity();
    for (const Face& face : faces) {
      out = std::max(out, face.normal.dot(Eigen::Vector3f(x, y, z)) - face.offset);
    }
    float& value = field.at(x, y, z);
    value = std::min(value, level + slope * (margin - out));
  };
  const int n = field.size().x();
  for (int z = 0; z < field.size().z(); ++z) {
    for (int y = 0; y < field.size().y(); ++y) {
      const auto [outer_low, outer_high] = row_within(faces, y, z, margin + kNear);
      const auto [inner_low, inner_high] = row_within(faces, y, z, margin - kNear);
      for (int x = 0; x < n; ++x) {
        if (x > inner_low && x < inner_high) {
          x = std::min(n, static_cast<int>(std::ceil(inner_high))) - 1;
        } else if (x >= outer_low && x <= outer_high) {
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
