#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "prehend/motion/collision_world.h"

namespace prehend::motion {

struct RrtOptions {
  double step = 0.4;         // rad or m: length of a branch in joint space, > 0
  double resolution = 0.05;  // rad or m, of any joint, between positions tested in the search, > 0
  int iterations = 20000;    // random samples at most, >= 1
  double budget = 0;         // s of wall time; 0: iterations alone count
  int shortcuts = 200;       // that are tried on the path at most, >= 0
  std::uint64_t seed = 1;
};

/// Joint positions from a start to a goal, straight between waypoints.
struct JointPath {
  std::vector<robot::Positions> waypoints;  // empty: none was found
  int goal = -1;                            // index of the goal that was reached
  std::string reason;                       // why there is none
  int iterations = 0;
  double completed = 0;  // of straight_path(): the share of the way that was free, 1 when found

  bool found() const { return !waypoints.empty(); }
  /// Sum of the distances between waypoints in joint space.
  double length() const;
};

/// A free path by RRT-Connect (J. J. Kuffner and S. M. LaValle, "RRT-Connect: An efficient approach
/// to single-query path planning", ICRA 2000) with one tree from the start and one from all goals,
/// then shortened: waypoints that a straight line can skip are dropped, corners cut until a round
/// gains less than 1 %. A straight line to the nearest goal is tried first. The path is
/// RobotInWorld::is_swept_free(): where it is not, the search is repeated at half the resolution,
/// at most four times. Same input and seed, same path, unless the budget ends the search. Reasons:
/// the start or all goals are not free (with what they touch), no goals, or the search ended.
/// @throws std::invalid_argument for a bad option, or positions of another size or not finite.
JointPath plan_path(const RobotInWorld& robot, const Eigen::Ref<const Eigen::VectorXd>& start,
                    const std::vector<robot::Positions>& goals, const RrtOptions& options = {});

/// A straight motion of the tip from its pose at `start` to `X_BT` (position straight, orientation
/// along the shortest turn), followed by Newton steps on the Jacobian, `step` [m] or 0.05 rad at a
/// time, and free between these as well. There is none when a joint would jump, a limit or an
/// obstacle is in the way, or the pose is lost by more than 0.1 mm or 0.1 mrad; `reason` says how
/// far it came.
/// @throws std::invalid_argument as plan_path.
JointPath straight_path(const RobotInWorld& robot, const Eigen::Ref<const Eigen::VectorXd>& start,
                        const geometry::RigidTransform& X_BT, double step = 0.01);

}  // namespace prehend::motion
