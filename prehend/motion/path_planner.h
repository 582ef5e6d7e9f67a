#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "prehend/motion/free_space.h"

namespace prehend::motion {

/// What any planner is told.
struct PathOptions {
  double step = 0.8;         // rad or m: length of a branch in joint space, > 0
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
  double length() const {
    double length = 0;
    for (std::size_t i = 1; i < waypoints.size(); ++i) {
      length += (waypoints[i] - waypoints[i - 1]).norm();
    }
    return length;
  }
};

/// A way to find a free path. Used by plan_path() (plan_path.h), which tests the ends before, and
/// afterwards shortens the path and sees to it that it is free between tested positions too. Recipe
/// for another one: README.md beside this file.
class PathPlanner {
 public:
  virtual ~PathPlanner() = default;

  virtual std::string name() const = 0;  // by which it is chosen: "rrt_connect"
  /// One line for who chooses: the method with its source, and what it cannot promise.
  virtual std::string about() const = 0;
  /// A path from `start` to any of `goals`, each piece FreeSpace::is_free_between() at
  /// options.resolution, or the reason why there is none. Its first waypoint is the start, its last
  /// goals[JointPath::goal]. Reentrant.
  /// @param start, goals free, finite and of the space's size; at least one goal.
  /// @param options in their ranges; `shortcuts` is not of its concern.
  virtual JointPath plan(const FreeSpace& space, const Eigen::Ref<const Eigen::VectorXd>& start,
                         const std::vector<robot::Positions>& goals,
                         const PathOptions& options) const = 0;
};

/// Of PathPlanner, FreeSpace, PathOptions and JointPath: a plug-in that was built for another one
/// is not loaded.
constexpr int kPlannerInterface = 1;

}  // namespace prehend::motion
