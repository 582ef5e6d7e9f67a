#pragma once

#include <algorithm>
#include <cmath>

#include "msgs/actions.pb.h"
#include "prehend/motion/trajectory.h"
#include "prehend/robot/kinematic_chain.h"

namespace prehend::tools {

/// The goal of /arm/follow along a motion::Trajectory or BlendedTrajectory, a point each 0.02 s.
template <class Path>
msgs::FollowTrajectoryGoal arm_goal(const robot::KinematicChain& chain, const Path& trajectory) {
  constexpr double kSamplePeriod = 0.02;  // s
  msgs::FollowTrajectoryGoal goal;
  msgs::JointTrajectory& path = *goal.mutable_trajectory();
  for (const robot::ChainJoint& joint : chain.joints()) path.add_joint_name(joint.name);
  const double duration = trajectory.duration();
  const int steps = std::max(1, static_cast<int>(std::ceil(duration / kSamplePeriod)));
  for (int i = 0; i <= steps; ++i) {
    const motion::TrajectoryPoint at = trajectory.at(duration * i / steps);
    msgs::JointTrajectoryPoint& point = *path.add_points();
    point.set_time(duration * i / steps);
    for (Eigen::Index j = 0; j < at.position.size(); ++j) {
      point.add_position(at.position[j]);
      point.add_velocity(at.velocity[j]);
      point.add_acceleration(at.acceleration[j]);
    }
  }
  return goal;
}

}  // namespace prehend::tools
