#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/shape/completed_shape.h"

namespace prehend::shape {

/// The seen points that vote, in a frame T that is fixed to table and camera: z is the table's
/// normal, x the camera's forward direction along the table, the origin the camera's foot on it.
struct VotingPoints {
  geometry::RigidTransform X_WT;
  /// One per voxel, in an order that the input's does not set.
  std::vector<Eigen::Vector3d> points_T;
  std::vector<Eigen::Vector3d> coarse_points_T;  // the same from voxels three times as long
  double extent = 0;  // longer side of the cloud's bounds along T's x and y [m]
  Eigen::Vector3d center_T = Eigen::Vector3d::Zero();  // mean of points_T
  Eigen::Vector2d away_T = Eigen::Vector2d::UnitX();   // unit, from the viewer to the center
};

/// Thins the cloud to one point per voxel of side `thinning` * its longest side; 0 keeps all.
/// O(points log points).
/// @throws geometry::InputError for fewer than 10 points, one that is not finite, or when all lie
/// on a line or in a plane (within 1 % of their spread), or when the viewpoint lies among them.
VotingPoints make_voting_points(const ObjectView& view, double thinning);

/// Directions along the table (unit, pointing away from the viewer) of normals that the footprint
/// suggests: both eigenvectors of the projected points, the one that equation (1) of
/// tests/oracles/reference_vote.h chooses first, then the sides of the smallest rectangle round the
/// footprint. With `first_only` only the first.
std::vector<Eigen::Vector2d> starting_normals(const VotingPoints& points, bool first_only);

}  // namespace prehend::shape
