#include "prehend/motion/convex_faces.h"

#include <algorithm>

#include "prehend/geometry/errors.h"

namespace prehend::motion {

using Eigen::Vector3d;

ConvexFaces convex_faces(const std::string& name, const geometry::TriangleMesh& mesh) {
  const geometry::TriangleMesh hull = geometry::convex_hull(mesh.vertices);
  ConvexFaces result;
  for (const Vector3d& p : hull.vertices) result.bounds.extend(p);
  for (const Vector3d& p : hull.vertices) {
    result.radius = std::max(result.radius, (p - result.bounds.center()).norm());
  }
  for (const Eigen::Vector3i& t : hull.triangles) {
    const Vector3d& a = hull.vertices[static_cast<std::size_t>(t.x())];
    const Vector3d normal = (hull.vertices[static_cast<std::size_t>(t.y())] - a)
                                .cross(hull.vertices[static_cast<std::size_t>(t.z())] - a);
    if (!(normal.norm() > 1e-14)) continue;
    const Vector3d unit = normal.normalized();
    result.faces.push_back({unit, unit.dot(a)});
  }
  if (result.faces.size() < 4) {
    throw geometry::InputError("The convex piece '" + name + "' has no volume",
                               "Leave it out, or give it a thickness");
  }
  return result;
}

}  // namespace prehend::motion
