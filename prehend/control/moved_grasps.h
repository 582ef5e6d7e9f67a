#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/grasp/planner.h"

namespace prehend::control {

/// What a carrier that moves along x, y, z and turns about the vertical can still take.
struct MovedGraspLimits {
  Eigen::Vector3d up_W = Eigen::Vector3d::UnitZ();  // unit, away from the table
  double largest_tilt = 0.1;        // rad, > 0, by which the object may lean otherwise than before
  double largest_drop = 0.01;       // m, > 0, by which it may have sunk: else it fell off something
  Eigen::AlignedBox3d workspace_W;  // m, of the hand's frame and its pregrasp; empty: no limit
};

struct MovedGrasps {
  std::vector<grasp::Grasp> grasps;  // in their order, where the object is now
  std::vector<std::size_t> indices;  // of each among those given
  std::string problem;               // why there are none, in words, else empty
};

/// The grasps of a plan for an object that has moved by `X_moved` since: the pose now times the
/// inverse of that which the plan was made for, both in W. Approaches stay upright as they were, so
/// an object that leans otherwise by a little is met between the same contacts. Whether something
/// else stands where the object is now is not looked at. O(grasps).
MovedGrasps moved_grasps(const std::vector<grasp::Grasp>& grasps,
                         const geometry::RigidTransform& X_moved,
                         const MovedGraspLimits& limits = {});

}  // namespace prehend::control
