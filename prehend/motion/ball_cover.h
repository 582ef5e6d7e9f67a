#pragma once

#include <vector>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::motion {

struct Ball {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();  // m
  double radius = 0;                                 // m
};

/// Balls that together hold a body's surface.
struct BallCover {
  std::vector<Ball> balls;
  double overshoot = 0;  // m: no ball reaches farther than this beyond the body
};

/// Covers the surfaces of the convex hulls of `pieces` (all in one frame) with one ball for each
/// cell of a grid of `resolution` [m]; a centre outside of its hull is moved into it, face by face,
/// which brings it nearer to every point of the hull, so that the ball can shrink. It reaches
/// beyond the hull by at most 0.87 resolutions, and every radius is at least 1 um. Flat pieces are
/// covered as the thin slabs that convex_faces() makes of them.
/// @throws std::invalid_argument for a resolution that is not positive; geometry::InputError for a
/// piece without finite vertices, or for more than 20000 cells.
BallCover cover_convex_pieces(const std::vector<geometry::TriangleMesh>& pieces,
                              double resolution = 0.015);

}  // namespace prehend::motion
