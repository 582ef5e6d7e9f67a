#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/control/joint_trajectory.h"
#include "prehend/robot/fingertips.h"

// A hand that has met a thing beside where that was predicted puts itself in its middle.
namespace prehend::control {

/// A straight way of the open hand from where it closes, that was found free of everything but what
/// it grasps.
struct HandShift {
  Eigen::Vector3d way_W = Eigen::Vector3d::Zero();  // m
  std::vector<double> offsets;                      // rad or m, of the arm's joints at its end
};

/// How far the thing is beside its prediction, by where the motors were stopped [m, world]: the
/// least displacement which, with a common advance of all fingers (a thing that is narrower or
/// wider than predicted), explains best how far each fingertip has gone, along the way that it
/// closes, beyond where it was predicted to be stopped. Zero when fewer than two fingers were
/// stopped. After the idea of J. Felip and A. Morales, "Robust sensor-based grasp primitive for a
/// three-finger robot hand", IROS 2009.
/// @param predicted where the motors were to be stopped [rad or m].
/// @param stopped where they were; fingers of which all motors are where they were `sent`, within
/// 0.02, have met nothing.
/// @param fingertips robot::fingertip_ways(), turned to the world.
/// @pre all are of the same motors.
Eigen::Vector3d displacement_felt(const Eigen::VectorXd& closing_rate,
                                  const Eigen::VectorXd& predicted, const Eigen::VectorXd& stopped,
                                  const Eigen::VectorXd& sent,
                                  const robot::FingertipWays& fingertips);

/// What of a displacement [m, world] the hand can follow.
struct FollowedShift {
  Eigen::Vector3d way_W = Eigen::Vector3d::Zero();  // m
  std::vector<double> offsets;                      // rad or m, of the arm's joints; empty: none
};
/// By its shares of `shifts`, each at most whole. @pre all have as many offsets.
FollowedShift followed(const Eigen::Vector3d& displacement_W, const std::vector<HandShift>& shifts);

}  // namespace prehend::control
