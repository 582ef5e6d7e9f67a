#pragma once

#include <vector>

#include "prehend/motion/path_planner.h"

namespace prehend::motion {

/// A free path by `planner`, then shortened: waypoints that a straight line can skip are dropped,
/// corners cut until a round gains less than 3 %. Each piece of the path is, or is part of, a line
/// that is FreeSpace::is_swept_free(): where one is not, the planner is asked again at half the
/// resolution, at most four times. Reasons: the start or all goals are not free (with what they
/// touch), no goals, or the planner's. Same input and seed, same path, as far as the planner's
/// about() does not except it, and unless the budget ends the search; the budget is of searching,
/// shortening comes on top.
/// @throws std::invalid_argument for a bad option, or positions of another size or not finite.
JointPath plan_path(const PathPlanner& planner, const FreeSpace& space,
                    const Eigen::Ref<const Eigen::VectorXd>& start,
                    const std::vector<robot::Positions>& goals, const PathOptions& options = {});

/// @throws std::invalid_argument naming `what` unless `q` is finite and of the space's size.
void check_positions(const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& q,
                     const char* what);

}  // namespace prehend::motion
