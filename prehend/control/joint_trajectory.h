#pragma once

#include <string>
#include <vector>

namespace prehend::control {

/// Joint positions over time, as msgs.JointTrajectory.
struct JointTrajectory {
  struct Point {
    double time = 0;                                       // s, from the start
    std::vector<double> position, velocity, acceleration;  // rad or m, per s, per s^2; may be empty
  };
  std::vector<std::string> joints;
  std::vector<Point> points;

  double duration() const { return points.empty() ? 0 : points.back().time; }  // s
};

/// The same way back.
JointTrajectory reversed(const JointTrajectory& path);

/// The first `share` of the path, in (0, 1], that begins and ends at rest: the way that the path
/// has gone by that share of its time, along s(t) = 10 t^3 - 15 t^4 + 6 t^5, as slowly as keeps
/// below the path's speeds. The whole path for 1.
JointTrajectory part_of(const JointTrajectory& path, double share);

/// Where on a path an arm that stands at `positions` of `names` is nearest to it.
struct PlaceOnPath {
  double share = 0;  // of its time, 0 to 1
  double off = 0;    // rad or m, of the joint that is farthest from there
};
/// By straight lines between its points. @throws as joined().
PlaceOnPath nearest_on(const JointTrajectory& path, const std::vector<std::string>& names,
                       const std::vector<double>& positions);

/// The share of its way, joint space's lengths between its points, that the path has gone by a
/// share of its time, and the share of its time by which it has gone a share of its way; all 0
/// to 1. Of a short straight way of the tool it is that way's share, too. A path without a way has
/// gone it at once.
double way_gone(const JointTrajectory& path, double share_of_time);
double time_of_way(const JointTrajectory& path, double share_of_way);

/// `path` from where the arm stands: what its first point is off by fades out (smoothly, 6s^5 -
/// 15s^4 + 10s^3) along the way, which takes longer where it would ask a joint for more speed or
/// acceleration than planned (and more than 0.5 rad/s, 2.5 rad/s^2). For an arm that contact
/// stopped short of a segment's end.
/// @throws std::invalid_argument in words when the arm is more than `most` [rad] off, a joint of
/// the path is not among `names`, or the path is empty.
JointTrajectory joined(JointTrajectory path, const std::vector<std::string>& names,
                       const std::vector<double>& positions, double most);

/// `path` with its joints `offsets` away [rad or m] all along. @pre no more offsets than joints
JointTrajectory beside(JointTrajectory path, const std::vector<double>& offsets);

/// `path` as far beside itself, all along, as the arm stands beside its start: for small ways about
/// the tool's path moved as a whole.
/// @throws std::invalid_argument as joined().
JointTrajectory displaced(JointTrajectory path, const std::vector<std::string>& names,
                          const std::vector<double>& positions, double most);

}  // namespace prehend::control
