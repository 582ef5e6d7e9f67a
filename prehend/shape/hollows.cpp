#include "prehend/shape/hollows.h"

#include <algorithm>
#include <limits>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::shape {
namespace {

struct Face {
  Eigen::Vector3d normal;  // unit, outwards
  double offset;
};

}  // namespace

Hollows hollows(const std::vector<Eigen::Vector3d>& points, const Eigen::Vector3d& viewpoint,
                const Eigen::Vector3d& up, double least_depth) {
  constexpr double kLooksUp = 0.8;  // cosine
  const geometry::TriangleMesh hull = geometry::convex_hull(points);
  Eigen::Vector3d inside = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : hull.vertices) inside += p;
  inside /= static_cast<double>(hull.vertices.size());
  std::vector<Face> faces;
  for (const Eigen::Vector3i& t : hull.triangles) {
    const Eigen::Vector3d a = hull.vertices[t.x()];
    Eigen::Vector3d normal = (hull.vertices[t.y()] - a).cross(hull.vertices[t.z()] - a);
    if (!(normal.norm() > 0)) continue;
    normal.normalize();
    if (normal.dot(inside - a) > 0) normal = -normal;
    faces.push_back({normal, normal.dot(a)});
  }
  Hollows result;
  for (const Eigen::Vector3d& p : points) {
    const Eigen::Vector3d sight = (viewpoint - p).normalized();
    double way = std::numeric_limits<double>::infinity();
    const Face* out = nullptr;
    for (const Face& face : faces) {
      const double speed = face.normal.dot(sight);
      if (speed <= 1e-9) continue;
      const double reach = std::max(0.0, (face.offset - face.normal.dot(p)) / speed);
      if (reach < way) {
        way = reach;
        out = &face;
      }
    }
    if (out == nullptr) continue;
    result.depth += way;
    result.open_top += way > least_depth && out->normal.dot(up) > kLooksUp;
  }
  result.depth /= static_cast<double>(points.size());
  result.open_top /= static_cast<double>(points.size());
  return result;
}

}  // namespace prehend::shape
