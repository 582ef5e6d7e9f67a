#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "eval/motion/motion_problem.h"
#include "prehend/robot/kinematic_chain.h"

namespace prehend::eval {

/// Whether paths are free, by the robot's own collision meshes, obstacles as they are, and the
/// Flexible Collision Library: shares nothing with the planner but the kinematics.
class PathOracle {
 public:
  /// @param may_touch pairs of links that may, of the robot's SRDF; links that no joint moves
  ///     against each other may, too
  /// @throws as robot::KinematicChain.
  PathOracle(const robot::RobotModel& model, const std::string& base, const std::string& tip,
             const std::vector<std::pair<std::string, std::string>>& may_touch);
  ~PathOracle();

  /// Obstacles from now on.
  void set_obstacles(const std::vector<MotionObstacle>& obstacles);
  /// "'panda_hand' touches 'shelf'"; empty: it is free.
  std::string problem(const Eigen::Ref<const Eigen::VectorXd>& q) const;
  /// The same of the first position that is not free along straight lines between waypoints, tested
  /// at steps of at most `step` [rad or m] of any joint; with where it is. @pre step > 0
  std::string problem_along(const std::vector<robot::Positions>& waypoints, double step) const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace prehend::eval
