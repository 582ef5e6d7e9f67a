#pragma once

#include <cstddef>
#include <vector>

#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::belief {

/// How far what is held may have moved in the hand: standard deviations, > 0.
struct HeldPrior {
  double along = 0.001;  // m, in each direction
  double turn = 0.01;    // rad, about each axis
};

/// Where one look has found what is held.
struct HeldPose {
  /// Of the frame that the look's points are given in, in that of the known ones.
  geometry::RigidTransform X_KS = geometry::RigidTransform::Identity();
  std::size_t matched = 0;  // of its points: beside one of another look that faces the same way
  double residual = 0;      // m, root mean square, of those along the others' normals
};

/// Where looks at the same thing lie on what is known of it and on each other, beginning where the
/// hand is thought to hold it (the identity): the likeliest poses when closing may have moved it by
/// `closing` before the first look, and turning it by `holding` between each two, and each point
/// that has a match in another look is off that one along its normal by about 1.5 mm.
/// Point-to-plane ICP (Chen and Medioni 1992) of all looks at once, with what the hand says as
/// prior: what points do not tell, as how far along a wall they are, stays as the hand says, and
/// what a later look tells of how it lies in the hand puts the earlier ones right. Points farther
/// from a match than a bound that shrinks from 12 to 4 mm count nothing, nor those that face
/// another way.
/// @param known, looks with normals. Few or no matches leave a look where it was thought to be.
/// @return one pose for each look. @throws std::invalid_argument for a prior that is not positive,
/// or points without normals.
std::vector<HeldPose> held_poses(const geometry::PointCloud& known_K,
                                 const std::vector<geometry::PointCloud>& looks_S,
                                 const HeldPrior& closing, const HeldPrior& holding);

}  // namespace prehend::belief
