#pragma once

#include <vector>

#include "prehend/robot/kinematic_chain.h"

namespace prehend::motion {

struct TrajectoryPoint {
  robot::Positions position;      // rad or m
  robot::Positions velocity;      // rad/s or m/s
  robot::Positions acceleration;  // rad/s^2 or m/s^2
};

/// Motion along straight lines in joint space with a stop at each waypoint: on each line all joints
/// start and end together, with a trapezoid of speed that keeps every joint's limits; time-optimal
/// among such motions.
class Trajectory {
 public:
  /// @param speed_factor of the joints' velocity limits, in (0, 1].
  /// @param max_acceleration of each joint [rad/s^2 or m/s^2], > 0.
  /// @throws std::invalid_argument without waypoints, for positions of another size or not finite,
  /// a bad factor, or a joint without a velocity limit.
  Trajectory(const robot::KinematicChain& chain, std::vector<robot::Positions> waypoints,
             const Eigen::Ref<const Eigen::VectorXd>& max_acceleration, double speed_factor = 1);

  double duration() const { return starts_.back(); }  // s
  /// At `time` [s] from the start; at rest before it and after the end.
  TrajectoryPoint at(double time) const;

 private:
  /// The share of a line that is done: speeds up, cruises, slows down.
  struct Profile {
    double speed = 0, acceleration = 0;  // 1/s, 1/s^2
    double ramp = 0, duration = 0;       // s
  };
  std::vector<robot::Positions> waypoints_;
  std::vector<Profile> profiles_;
  std::vector<double> starts_;  // s, of each line; the last: the end
};

}  // namespace prehend::motion
