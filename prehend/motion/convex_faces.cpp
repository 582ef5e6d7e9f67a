#include "prehend/motion/convex_faces.h"

#include <algorithm>
#include <iterator>
#include <limits>

#include <Eigen/Eigenvalues>

#include "prehend/geometry/errors.h"

namespace prehend::motion {

using Eigen::Vector3d;

namespace {

constexpr double kLeastThickness = 1e-4;          // m
constexpr double kLeastRelativeThickness = 1e-3;  // of the largest extent
constexpr double kHullGrid = 1e-3;                // of the largest extent; the hull's is 1e-4

void check_points(const std::string& name, const std::vector<Vector3d>& points) {
  const bool finite =
      std::all_of(points.begin(), points.end(), [](const Vector3d& p) { return p.allFinite(); });
  if (!points.empty() && finite) return;
  throw geometry::InputError(
      "The convex piece '" + name +
          (finite ? "' has no vertices" : "' has a vertex that is no number"),
      "Leave it out, or give it finite vertices");
}

// Adds points so that the hull of all has a volume.
std::vector<Vector3d> thickened(std::vector<Vector3d> points) {
  Vector3d mean = Vector3d::Zero();
  for (const Vector3d& p : points) mean += p / static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Vector3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  const Eigen::Matrix3d axes =
      Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(covariance).eigenvectors();
  Eigen::AlignedBox3d extent;
  for (const Vector3d& p : points) extent.extend(Vector3d(axes.transpose() * (p - mean)));
  const double least =
      std::max(kLeastThickness, kLeastRelativeThickness * extent.sizes().maxCoeff());
  for (int k = 0; k < 3; ++k) {
    if (extent.sizes()[k] >= least) continue;
    const std::size_t count = points.size();
    for (std::size_t i = 0; i < count; ++i) {
      points.push_back(points[i] + least / 2 * axes.col(k));
      points[i] -= least / 2 * axes.col(k);
    }
  }
  return points;
}

}  // namespace

ConvexFaces convex_faces(const std::string& name, const geometry::TriangleMesh& mesh) {
  check_points(name, mesh.vertices);
  const std::vector<Vector3d> points = thickened(mesh.vertices);
  const geometry::TriangleMesh hull = geometry::convex_hull(points);
  ConvexFaces result;
  for (const Vector3d& p : points) result.bounds.extend(p);
  for (const Vector3d& p : points) {
    result.radius = std::max(result.radius, (p - result.bounds.center()).norm());
  }
  for (const Eigen::Vector3i& t : hull.triangles) {
    const Vector3d& a = hull.vertices[static_cast<std::size_t>(t.x())];
    const Vector3d normal = (hull.vertices[static_cast<std::size_t>(t.y())] - a)
                                .cross(hull.vertices[static_cast<std::size_t>(t.z())] - a);
    if (!(normal.norm() > 1e-14)) continue;
    const Vector3d unit = normal.normalized();
    // The hull's vertices are on a grid of a ten-thousandth of the extent, and a sliver's normal
    // can be far off: each plane is moved to where nothing is cut away.
    double offset = -std::numeric_limits<double>::infinity();
    for (const Vector3d& p : points) offset = std::max(offset, unit.dot(p));
    result.faces.push_back({unit, offset});
  }
  // A corner of the hull is on a face, up to the hull's grid.
  const double grid = kHullGrid * result.bounds.sizes().maxCoeff();
  std::copy_if(points.begin(), points.end(), std::back_inserter(result.points), [&](const auto& p) {
    return std::any_of(result.faces.begin(), result.faces.end(),
                       [&](const auto& face) { return face.signed_distance(p) > -grid; });
  });
  return result;
}

}  // namespace prehend::motion
