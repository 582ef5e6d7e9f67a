#pragma once

#include <algorithm>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::grasp {

struct SolidBall {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // m
  double radius = 0;                                 // m
};

/// How far beneath its faces the balls of a shape with this smallest side have their centres [m],
/// which rounds its edges by as much.
inline double ball_inset(double smallest_side) {
  return std::min(smallest_side / 2, std::clamp(0.18 * smallest_side, 0.003, 0.010));
}

/// Balls beneath the surface of a closed mesh, by which it is touched: faces are true to
/// `tolerance` [m], convex edges are rounded by about ball_inset() of the smallest side of the
/// mesh's bounds, and thin things that stand out by less than three quarters of it are lost. A ball
/// touches the surface from within and is the largest that fits there (J. Ma, S. Bae, S. Choi, "3D
/// medial axis point approximation using nearest neighbors and the normal field", 2012), up to that
/// inset, so what is thin has small ones; then it grows by the tolerance, since between balls the
/// surface is as much too low. The largest are taken first, until all points of the surface, half a
/// millimetre apart, are held. `solid` need not be convex. Where its shells overlap, faces inside
/// count as walls: a millimetre may be missing above their edges.
/// @throws geometry::InputError for a mesh without triangles, or with NaN.
std::vector<SolidBall> balls_within(const geometry::TriangleMesh& solid, double tolerance);

}  // namespace prehend::grasp
