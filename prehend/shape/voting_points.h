#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/shape/completed_shape.h"

namespace prehend::shape {

/// The seen points that vote, in a frame T that is fixed to table and camera: z is the table's
/// normal, x the camera's forward direction along the table, the origin the camera's foot on it.
struct VotingPoints {
  geometry::RigidTransform X_WT;
  std::vector<Eigen::Vector3d>
      points_T;       // one per voxel, in an order that the input's does not set
  double extent = 0;  // longer side of the cloud's bounds along T's x and y [m]
  Eigen::Vector2d center_T = Eigen::Vector2d::Zero();  // mean along the table [m]
  Eigen::Vector2d away_T = Eigen::Vector2d::UnitX();   // unit, from the viewer to the center
};

/// Thins the cloud to one point per voxel of side `thinning` * extent.
/// @throws geometry::InputError for fewer than 10 points, one that is not finite, or when all lie
/// on a line or in a plane (within 1 % of their spread).
VotingPoints make_voting_points(const ObjectView& view, double thinning);

/// Directions along the table (unit, pointing away from the viewer) of the normals from which the
/// search starts: first the eigenvector of the projected points whose perpendicular is most
/// perpendicular to the viewing direction, then, with `footprint_axes`, the sides of the smallest
/// rectangle round the footprint that are within 50 deg of the viewing direction and further than
/// `distinct` [rad] from the first.
std::vector<Eigen::Vector2d> starting_normals(const VotingPoints& points, bool footprint_axes,
                                              double distinct);

}  // namespace prehend::shape
