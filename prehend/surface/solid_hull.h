#pragma once

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// How points lie about their mean.
struct Scatter {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  double squares = 0;   // sum of the squared distances to it
  double solidity = 0;  // determinant of the covariance over its trace: 1/27 of a ball's, 0 of what
                        // is flat or one point
};
/// @pre there is a point.
Scatter scatter_of(const std::vector<Eigen::Vector3d>& points);

/// Convex hull of `points` with at most `max_vertices`, the extreme points along as many directions
/// spread over the sphere; none when the points have no volume.
std::optional<geometry::TriangleMesh> solid_hull(const std::vector<Eigen::Vector3d>& points,
                                                 std::size_t max_vertices);

/// @throws geometry::InputError when `mesh` has no triangles, vertices that are not finite or
/// indices out of range.
void check_indices_and_vertices(const geometry::TriangleMesh& mesh);

}  // namespace prehend::surface
