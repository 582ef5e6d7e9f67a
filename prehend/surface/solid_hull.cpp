#include "prehend/surface/solid_hull.h"

#include <cmath>

#include "prehend/geometry/errors.h"
#include "prehend/surface/extremes.h"
#include "prehend/surface/hull_faces.h"

namespace prehend::surface {

using geometry::InputError;
using geometry::TriangleMesh;

namespace {

constexpr std::size_t kFewPoints = 500;
constexpr std::size_t kFewDirections = 48;

/// The points farthest along `count` directions spread over the sphere.
std::vector<Eigen::Vector3d> outermost(const std::vector<Eigen::Vector3d>& points,
                                       std::size_t count) {
  std::vector<Eigen::Vector3d> extremes;
  for (const std::size_t i : extremes_of(points, spread_directions<double>(count))) {
    extremes.push_back(points[i]);
  }
  return extremes;
}

}  // namespace

Scatter scatter_of(const std::vector<Eigen::Vector3d>& points) {
  Scatter scatter;
  for (const Eigen::Vector3d& p : points) scatter.mean += p;
  scatter.mean /= static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) {
    covariance += (p - scatter.mean) * (p - scatter.mean).transpose();
  }
  scatter.squares = covariance.trace();
  if (scatter.squares > 0) scatter.solidity = (covariance / scatter.squares).determinant();
  return scatter;
}

std::optional<TriangleMesh> solid_hull(const std::vector<Eigen::Vector3d>& points,
                                       std::size_t max_vertices) {
  if (points.size() < 4) return std::nullopt;
  const Scatter scatter = scatter_of(points);
  if (!(scatter.solidity > 1e-12)) return std::nullopt;

  // Most points lie within the hull of a few extreme ones and need not be looked at again.
  std::vector<Eigen::Vector3d> outer = points;
  if (points.size() > kFewPoints) {
    const TriangleMesh inner = geometry::convex_hull(outermost(points, kFewDirections));
    const double scale = 1 / std::sqrt(scatter.squares / static_cast<double>(points.size()));
    TriangleMesh scaled = inner;
    for (Eigen::Vector3d& p : scaled.vertices) p = scale * (p - scatter.mean);
    const HullFaces faces(scaled);
    outer = inner.vertices;
    for (const Eigen::Vector3d& p : points) {
      if (faces.distance((scale * (p - scatter.mean)).cast<float>()) > -1e-5f) outer.push_back(p);
    }
  }
  TriangleMesh hull = geometry::convex_hull(outer);
  if (hull.vertices.size() <= max_vertices) return hull;
  return geometry::convex_hull(outermost(hull.vertices, max_vertices));
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
