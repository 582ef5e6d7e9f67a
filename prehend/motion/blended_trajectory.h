#pragma once

#include <vector>

#include "prehend/motion/blended_path.h"
#include "prehend/motion/trajectory.h"

namespace prehend::motion {

/// The fastest motion along a path, from rest to rest, within velocity and acceleration limits.
///
/// With s the length along the path, joint j moves at f'_j(s) ds/dt and is accelerated by
/// f'_j(s) u + f''_j(s) x, where x = (ds/dt)^2 and u = d^2s/dt^2, so that dx/ds = 2 u. Both are
/// linear in (u, x): the largest x from which the rest of the path can be followed is found from
/// the end backwards, and the largest u that keeps below it is taken from the start forwards (H.
/// Pham and Q.-C. Pham, "A new approach to time-optimal path parameterization based on reachability
/// analysis", IEEE T-RO 34(3), 2018; with its "collocation and interpolation" scheme, section IV).
/// Lines are exact: speeding up, cruising, slowing down. Arcs are cut into angles of at most
/// `angle_step`, u is constant on each, limits are kept at both of its ends, and the whole is then
/// slowed by as much as a bound on what happens between them asks for. So limits are kept
/// everywhere, and the motion is the fastest up to terms that vanish with the step: at 0.02 rad
/// within 0.5 % of that at 0.001 rad.
class BlendedTrajectory {
 public:
  /// @param speed_factor of the joints' velocity limits, in (0, 1].
  /// @param max_acceleration of each joint [rad/s^2 or m/s^2], > 0.
  /// @throws std::invalid_argument for a path of another size, bad limits or factor, a joint that
  /// moves and has no velocity limit, or an angle_step [rad] that is not in (0, 0.5].
  BlendedTrajectory(const robot::KinematicChain& chain, BlendedPath path,
                    const Eigen::Ref<const Eigen::VectorXd>& max_acceleration,
                    double speed_factor = 1, double angle_step = 0.02);

  double duration() const { return duration_; }  // s
  /// At `time` [s] from the start; at rest before it and after the end.
  TrajectoryPoint at(double time) const;
  const BlendedPath& path() const { return path_; }

 private:
  /// A time of constant acceleration along one piece of the path.
  struct Phase {
    std::size_t piece = 0;
    double start = 0;       // s
    double along = 0;       // of the piece, at the start
    double speed = 0;       // of the path's length by time, at the start
    double last_speed = 0;  // and at the end
    double acceleration = 0;
  };
  struct Timing;

  BlendedPath path_;
  std::vector<Phase> phases_;
  double duration_ = 0;
};

struct TimingOptions {
  double deviation = 0.05;   // rad or m in joint space: how far an arc may pass a waypoint, >= 0
  double resolution = 0.02;  // rad or m of any joint, between positions tested on arcs, > 0
  double speed_factor = 1;   // of the joints' velocity limits, in (0, 1]
};

/// Motion along free lines in joint space, corners blended where arcs are free. Where the limits of
/// joints differ by orders of magnitude, a circle can cost more than a stop: then it stops at the
/// waypoints, so that it is never slower than Trajectory.
/// @throws std::invalid_argument as BlendedPath and BlendedTrajectory.
BlendedTrajectory blend_trajectory(const RobotInWorld& robot,
                                   const std::vector<robot::Positions>& waypoints,
                                   const Eigen::Ref<const Eigen::VectorXd>& max_acceleration,
                                   const TimingOptions& options = {});

}  // namespace prehend::motion
