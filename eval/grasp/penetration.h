#pragma once

#include <memory>
#include <vector>

#include <Eigen/Geometry>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/motion/collision_checker.h"

namespace prehend::eval {

/// Closed convex meshes in one frame, to be asked how deep others are in them; flat ones are none.
class ConvexSolids {
 public:
  explicit ConvexSolids(const std::vector<geometry::TriangleMesh>& pieces);

  const Eigen::AlignedBox3d& bounds() const { return bounds_; }

 private:
  friend double penetration(const ConvexSolids& a, const ConvexSolids& b,
                            const geometry::RigidTransform& X_AB);
  struct Piece {
    Eigen::AlignedBox3d bounds;
    Eigen::Matrix3Xd vertices, normals;  // of faces, unit, outward
    std::shared_ptr<const motion::CheckedBody> body;
  };
  std::vector<Piece> pieces_;
  Eigen::AlignedBox3d bounds_;
};

/// How deep two solids are in one another [m], `b` in the frame of `a` by X_AB: of the pairs of
/// pieces that overlap, the largest of the shortest ways along a face's normal of either piece that
/// part them. Not less than the shortest way in any direction, and the same but where that is along
/// no face's normal. 0: they are apart.
double penetration(const ConvexSolids& a, const ConvexSolids& b,
                   const geometry::RigidTransform& X_AB);

}  // namespace prehend::eval
