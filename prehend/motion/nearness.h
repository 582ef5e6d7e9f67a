#pragma once

#include <limits>
#include <string>

#include "prehend/motion/robot_in_world.h"

namespace prehend::motion {

/// How near a robot is to touching something, and who to what.
struct Nearness {
  /// m, between surfaces, negative where they overlap; from obstacles less the robot's margin.
  /// Infinite where there is nothing to touch.
  double distance = std::numeric_limits<double>::infinity();
  int ball = -1;         // of RobotInWorld::spheres()
  int other = -1;        // another of them; -1: an obstacle
  std::string obstacle;  // its name, where it is one
};

/// Of the robot's balls at `q`: from all obstacles, and between those that must not touch each
/// other. Never more than the true distance, as balls hold the shapes. Costs a distance for each
/// ball and obstacle and for each pair. Obstacles' own margins (CollisionWorld::set_margin()) and
/// another checker count nothing here. Reentrant. @pre q has as many entries as the robot has
/// joints
Nearness nearness(const RobotInWorld& robot, const Eigen::Ref<const Eigen::VectorXd>& q);

/// "the link of joint 'e2' and 'table'": of a nearness that has a ball.
std::string pair_of(const RobotInWorld& robot, const Nearness& near);

}  // namespace prehend::motion
