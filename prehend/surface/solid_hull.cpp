#include "prehend/surface/solid_hull.h"

#include <cmath>
#include <set>

#include "prehend/geometry/errors.h"

namespace prehend::surface {

using geometry::InputError;
using geometry::TriangleMesh;

std::optional<TriangleMesh> solid_hull(const std::vector<Eigen::Vector3d>& points,
                                       std::size_t max_vertices) {
  if (points.size() < 4) return std::nullopt;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  const double largest = covariance.trace();
  if (!(largest > 0) || !((covariance / largest).determinant() > 1e-12)) return std::nullopt;

  TriangleMesh hull = geometry::convex_hull(points);
  if (hull.vertices.size() <= max_vertices) return hull;
  std::set<std::size_t> chosen;
  const double golden = 2.399963229728653;  // rad, golden angle
  for (std::size_t i = 0; i < max_vertices; ++i) {
    const double z = 1 - (2 * i + 1.0) / static_cast<double>(max_vertices);
    const double r = std::sqrt(1 - z * z);
    const Eigen::Vector3d direction(r * std::cos(golden * i), r * std::sin(golden * i), z);
    std::size_t best = 0;
    for (std::size_t j = 1; j < hull.vertices.size(); ++j) {
      if (direction.dot(hull.vertices[j]) > direction.dot(hull.vertices[best])) best = j;
    }
    chosen.insert(best);
  }
  std::vector<Eigen::Vector3d> extremes;
  for (const std::size_t i : chosen) extremes.push_back(hull.vertices[i]);
  return geometry::convex_hull(extremes);
}

void check_indices_and_vertices(const TriangleMesh& mesh) {
  if (mesh.empty()) throw InputError("the mesh has no triangles", "give a closed mesh");
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    if (!vertex.allFinite()) {
      throw InputError("the mesh has vertices that are not finite", "give a closed mesh");
    }
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    if (t.minCoeff() < 0 || t.maxCoeff() >= static_cast<int>(mesh.vertices.size())) {
      throw InputError("the mesh has triangle indices out of range", "give a closed mesh");
    }
  }
}

}  // namespace prehend::surface
