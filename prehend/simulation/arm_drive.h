#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/robot/kinematic_chain.h"

namespace prehend::simulation {

/// Positions over time of an arm's joints, in the chain's order.
struct ArmTrajectory {
  struct Point {
    double time = 0;  // s, from the start
    robot::Positions position, velocity, acceleration;
  };
  std::vector<Point> points;  // times increase
  /// A point's velocities (and accelerations) are given: cubic (quintic) between points, else
  /// straight lines.
  bool has_velocity = false, has_acceleration = false;

  double duration() const { return points.back().time; }  // s
  /// At `time` [s]; at rest before the first point and after the last.
  Point at(double time) const;
};

/// A trajectory as somebody asks for it: names, and for each point times and values in their order.
struct TrajectoryRequest {
  std::vector<std::string> joints;
  struct Point {
    double time = 0;
    std::vector<double> position, velocity, acceleration;
  };
  std::vector<Point> points;
};

struct ArmDriveOptions {
  double acceleration = 12;           // rad/s^2 or m/s^2, > 0, of each joint at most
  std::vector<double> accelerations;  // the same of each; empty: `acceleration` of all
  double bandwidth = 60;              // rad/s, > 0, of the position loops (critically damped)
  double tracking_bandwidth = 30;     // the same while set points are tracked, which come in steps
  double start_tolerance = 0.02;      // rad or m, between where the arm stands and the first point
  double path_tolerance = 0.05;       // rad or m, of each joint while it moves
};

/// Checks `request` for an arm that stands at `q`, and puts it in the chain's order.
/// @throws std::invalid_argument in words that name joint, point and mend: a joint that is missing,
/// named twice or not the arm's (with the nearest name), no points, values that are not finite or
/// not one a joint, times that are negative or do not increase, a position or velocity beyond the
/// joint's limits, a start elsewhere than where the arm stands.
ArmTrajectory check_trajectory(const robot::KinematicChain& chain, const TrajectoryRequest& request,
                               const Eigen::Ref<const Eigen::VectorXd>& q,
                               const ArmDriveOptions& options = {});

/// A set point for an arm, put in the chain's order: `values` [rad or m] of `names`, each joint
/// once.
/// @throws std::invalid_argument in words, as check_trajectory().
robot::Positions check_set_point(const robot::KinematicChain& chain,
                                 const std::vector<std::string>& names,
                                 const std::vector<double>& values);

/// The arm's joints: position loops with feed-forward, within limits of velocity and acceleration.
/// The arm does not yield to what it touches: the servos of industrial arms are far stiffer than
/// fingers and contacts, and their robots' inertias are not published. So what is off the path is
/// what the limits do not allow. Its state is its value: copy to save.
class ArmDrive {
 public:
  enum class Status { kIdle, kMoving, kReached, kStopped, kOffPath, kTracking };

  ArmDrive(robot::KinematicChain chain, const Eigen::Ref<const Eigen::VectorXd>& start,
           const ArmDriveOptions& options = {});

  /// From where it stands or moves. `tolerance` of each joint, empty: the options'.
  void follow(const ArmTrajectory& trajectory, const std::vector<double>& tolerance = {});
  /// To `goal`, and there until told otherwise, within the limits; called again and again by who
  /// streams set points. @pre one position a joint, as check_set_point() returns
  void track(const robot::Positions& goal);
  /// Brakes each joint with the acceleration limit.
  void stop();
  /// Forgets the last trajectory, its error and reason.
  void forget();
  void step(double h);

  const robot::KinematicChain& chain() const { return chain_; }
  const robot::Positions& position() const { return q_; }
  const robot::Positions& velocity() const { return v_; }
  const robot::Positions& desired() const { return desired_; }
  double time() const { return time_; }  // s, on the trajectory
  bool at_rest() const { return v_.isZero(0); }
  /// Whether step() would do nothing.
  bool is_idle() const {
    return status_ != Status::kMoving && at_rest() &&
           (status_ != Status::kTracking || q_ == desired_);
  }
  Status status() const { return status_; }
  double largest_error() const { return largest_error_; }  // rad or m, on the way
  const std::string& reason() const { return reason_; }    // of kOffPath, in words

 private:
  robot::KinematicChain chain_;
  ArmDriveOptions options_;
  robot::Positions q_, v_, desired_;
  ArmTrajectory trajectory_;
  std::vector<double> tolerance_;
  Status status_ = Status::kIdle;
  double time_ = 0;
  double largest_error_ = 0;
  std::string reason_;
};

}  // namespace prehend::simulation
