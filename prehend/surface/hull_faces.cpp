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

// Face by face, so that the rows of one are worked on side by side.
void HullFaces::rows(float first, float z, float shift, std::vector<float>& low,
                     std::vector<float>& high) const {
  const std::size_t count = low.size();
  std::fill(low.begin(), low.end(), -std::numeric_limits<float>::infinity());
  std::fill(high.begin(), high.end(), std::numeric_limits<float>::infinity());
  for (const Face& face : faces_) {
    const float room = face.offset + shift - face.normal.y() * first - face.normal.z() * z;
    if (std::abs(face.normal.x()) < 1e-6f) {
      for (std::size_t i = 0; i < count; ++i) {
        if (room - face.normal.y() * static_cast<float>(i) < 0) {
          high[i] = -std::numeric_limits<float>::infinity();
        }
      }
      continue;
    }
    const float at_first = room / face.normal.x(), step = -face.normal.y() / face.normal.x();
    if (face.normal.x() > 0) {
      for (std::size_t i = 0; i < count; ++i) {
        high[i] = std::min(high[i], at_first + step * static_cast<float>(i));
      }
    } else {
      for (std::size_t i = 0; i < count; ++i) {
        low[i] = std::max(low[i], at_first + step * static_cast<float>(i));
      }
    }
  }
}

}  // namespace prehend::surface
