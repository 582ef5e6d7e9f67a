#pragma once

#include <vector>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval {

/// Closed convex meshes in one frame, by their faces' planes, to be asked how deep points are.
class ConvexSolids {
 public:
  explicit ConvexSolids(const std::vector<geometry::TriangleMesh>& pieces);

  /// How far `point` is from leaving the piece it is deepest in [m]; 0 outside of all.
  double depth(const Eigen::Vector3d& point) const;
  const std::vector<Eigen::Vector3d>& vertices() const { return vertices_; }
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }

 private:
  struct Piece {
    Eigen::AlignedBox3d bounds;
    std::vector<Eigen::Hyperplane<double, 3>> faces;  // normals outward
  };
  std::vector<Piece> pieces_;
  std::vector<Eigen::Vector3d> vertices_;
  Eigen::AlignedBox3d bounds_;
};

/// How deep two solids are in one another [m]: the deepest vertex of either within a piece of the
/// other, `b` in the frame of `a` by X_AB. Edges that cross without a vertex inside are not seen.
double penetration(const ConvexSolids& a, const ConvexSolids& b,
                   const geometry::RigidTransform& X_AB);

}  // namespace prehend::eval
