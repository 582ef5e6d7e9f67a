#pragma once

#include <string>
#include <vector>

#include "prehend/motion/path_planner.h"
#include "prehend/motion/robot_in_world.h"

namespace prehend::motion {

/// RRT-Connect (J. J. Kuffner and S. M. LaValle, "RRT-Connect: An efficient approach to
/// single-query path planning", ICRA 2000) with one tree from the start and one from all goals. A
/// straight line to the nearest goal is tried first. The tree that has grown less grows next, and
/// nodes at which something was in the way only towards samples that are near (after A. Yershova,
/// L. Jaillet, T. Simeon, S. M. LaValle, "Dynamic-domain RRTs", ICRA 2005). Every branch is swept
/// free. Same input and seed, same path, unless the budget ends the search.
class RrtConnect final : public PathPlanner {
 public:
  std::string name() const override { return "rrt_connect"; }
  std::string about() const override;
  JointPath plan(const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& start,
                 const std::vector<robot::Positions>& goals,
                 const PathOptions& options) const override;
};

/// plan_path() of plan_path.h by RrtConnect.
JointPath plan_path(const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& start,
                    const std::vector<robot::Positions>& goals, const PathOptions& options = {});

/// A straight motion of the tip from its pose at `start` to `X_BT` (position straight, orientation
/// along the shortest turn), followed by Newton steps on the Jacobian, `step` [m] or 0.05 rad at a
/// time, and free between these as well. There is none when a joint would jump, a limit or an
/// obstacle is in the way, or the pose is lost by more than 0.1 mm or 0.1 mrad; `reason` says how
/// far it came.
/// @throws std::invalid_argument as plan_path.
JointPath straight_path(const RobotInWorld& robot, const Eigen::Ref<const Eigen::VectorXd>& start,
                        const geometry::RigidTransform& X_BT, double step = 0.01);

}  // namespace prehend::motion
