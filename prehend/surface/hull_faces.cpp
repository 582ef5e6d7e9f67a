#include "prehend/surface/hull_faces.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace prehend::surface {

HullFaces::HullFaces(const geometry::TriangleMesh& hull) {
  for (const Eigen::Vector3i& t : hull.triangles) {
    const Eigen::Vector3d& a = hull.vertices[t.x()];
    const Eigen::Vector3d ab = hull.vertices[t.y()] - a;
    const Eigen::Vector3d ac = hull.vertices[t.z()] - a;
    const Eigen::Vector3d n = ab.cross(ac);
    if (!(n.norm() > 1e-6 * ab.norm() * ac.norm())) continue;
    const Eigen::Vector3d unit = n.normalized();
    faces_.push_back({unit.cast<float>(), static_cast<float>(unit.dot(a))});
  }
}

float HullFaces::distance(const Eigen::Vector3f& p) const {
  float greatest = -std::numeric_limits<float>::infinity();
  for (const Face& face : faces_) greatest = std::max(greatest, face.normal.dot(p) - face.offset);
  return greatest;
}

float HullFaces::thickness(const std::vector<Eigen::Vector3f>& points) const {
  float least = std::numeric_limits<float>::infinity();
  for (const Face& face : faces_) {
    float deepest = 0;
    for (const Eigen::Vector3f& p : points) {
      deepest = std::max(deepest, face.offset - face.normal.dot(p));
    }
    least = std::min(least, deepest);
  }
  return least;
}

std::pair<float, float> HullFaces::row(float y, float z, float shift) const {
  float low = -std::numeric_limits<float>::infinity();
  float high = std::numeric_limits<float>::infinity();
  for (const Face& face : faces_) {
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

}  // namespace prehend::surface
