#include "eval/grasp/penetration.h"

#include <algorithm>
#include <limits>

namespace prehend::eval {
namespace {

constexpr double kNoNormal = 1e-14;  // m^2, of a triangle without a plane

}  // namespace

ConvexSolids::ConvexSolids(const std::vector<geometry::TriangleMesh>& pieces) {
  for (const geometry::TriangleMesh& mesh : pieces) {
    Piece& piece = pieces_.emplace_back();
    piece.bounds = geometry::bounds(mesh);
    bounds_.extend(piece.bounds);
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const Eigen::Vector3d& a = mesh.vertices[t[0]];
      const Eigen::Vector3d normal = (mesh.vertices[t[1]] - a).cross(mesh.vertices[t[2]] - a);
      if (normal.norm() > kNoNormal) piece.faces.emplace_back(normal.normalized(), a);
    }
    vertices_.insert(vertices_.end(), mesh.vertices.begin(), mesh.vertices.end());
  }
}

double ConvexSolids::depth(const Eigen::Vector3d& point) const {
  double deepest = 0;
  if (!bounds_.contains(point)) return deepest;
  for (const Piece& piece : pieces_) {
    if (!piece.bounds.contains(point)) continue;
    double depth = std::numeric_limits<double>::infinity();
    for (const auto& face : piece.faces) {
      depth = std::min(depth, -face.signedDistance(point));
      if (depth <= deepest) break;
    }
    deepest = std::max(deepest, depth);
  }
  return deepest;
}

double penetration(const ConvexSolids& a, const ConvexSolids& b,
                   const geometry::RigidTransform& X_AB) {
  const geometry::RigidTransform X_BA = X_AB.inverse(Eigen::Isometry);
  double deepest = 0;
  for (const Eigen::Vector3d& p_B : b.vertices()) deepest = std::max(deepest, a.depth(X_AB * p_B));
  for (const Eigen::Vector3d& p_A : a.vertices()) deepest = std::max(deepest, b.depth(X_BA * p_A));
  return deepest;
}

}  // namespace prehend::eval
