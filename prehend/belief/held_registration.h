#pragma once

#include <cstddef>

#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::belief {

/// How far what is held may be from where the hand is thought to hold it: standard deviations, > 0.
struct HeldPrior {
  double along = 0.002;  // m, in each direction
  double turn = 0.03;    // rad, about each axis
};

struct HeldPose {
  /// Of the frame that the seen points are given in, in that of the known ones.
  geometry::RigidTransform X_KS = geometry::RigidTransform::Identity();
  std::size_t matched = 0;  // of the seen points: beside a known one that faces the same way
  double residual = 0;      // m, root mean square, of those along the known points' normals
};

/// Where what is seen lies on what is known of the same object, beginning where the hand is thought
/// to hold it (the identity): the likeliest of poses about that with the deviations of `prior`,
/// every matched point being off the known surface along its normal by about 1.5 mm (as
/// point-to-plane ICP, Chen and Medioni 1992, with a prior). What the points do not tell, as how
/// far along a wall they are, stays as the hand says. Points farther from a known one than a bound
/// that shrinks from 12 to 4 mm count nothing, nor those that face another way.
/// @param known, seen with normals. Few or no matches leave it where it was thought to be.
/// @throws std::invalid_argument for a prior that is not positive, or points without normals.
HeldPose held_pose(const geometry::PointCloud& known_K, const geometry::PointCloud& seen_S,
                   const HeldPrior& prior);

}  // namespace prehend::belief
