#pragma once

#include <cmath>
#include <map>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/robot/formats/robot_description.h"

// What a robot weighs for its motors, straight from the definition: an oracle for tests.
namespace prehend::robot::formats {

inline bool moves_by_itself(const JointDescription& joint) {
  return (joint.kind == JointDescription::Kind::kRevolute ||
          joint.kind == JointDescription::Kind::kPrismatic) &&
         !joint.follows;
}

/// Names of the joints that move by themselves, in the robot's order.
inline std::vector<std::string> free_joints(const RobotDescription& robot) {
  std::vector<std::string> names;
  for (const JointDescription& joint : robot.joints) {
    if (moves_by_itself(joint)) names.push_back(joint.name);
  }
  return names;
}

/// The joint-space mass matrix, joints.size() square [kg m^2, kg m, kg]: the sum over links of
/// m Jv^T Jv + Jw^T I Jw, where Jv moves the centre of mass and Jw turns the link; joints that
/// follow move with those that they follow. Its root stands still.
/// @param positions [rad or m] by joint; others are at 0
inline Eigen::MatrixXd mass_matrix(const RobotDescription& robot,
                                   const std::vector<std::string>& joints,
                                   const std::map<std::string, double>& positions) {
  const LinkPoses tree(robot);
  std::vector<double> q;
  std::map<std::string, Eigen::Index> column;
  for (const std::string& name : joints) column.emplace(name, column.size());
  for (const JointDescription& joint : robot.joints) {
    const auto found = positions.find(joint.name);
    q.push_back(found == positions.end() ? 0 : found->second);
  }
  const auto X_RL = tree.at(q);
  const auto n = static_cast<Eigen::Index>(joints.size());
  Eigen::MatrixXd M = Eigen::MatrixXd::Zero(n, n);
  for (std::size_t link = 0; link < robot.links.size(); ++link) {
    const auto& inertial = robot.links[link].inertial;
    if (!inertial) continue;
    const geometry::RigidTransform X_RI = X_RL[link] * inertial->X_LI;
    Eigen::MatrixXd Jv = Eigen::MatrixXd::Zero(3, n), Jw = Jv;
    for (int above = tree.joint_above()[link]; above >= 0;
         above = tree.joint_above()[static_cast<std::size_t>(
             tree.parent()[static_cast<std::size_t>(above)])]) {
      const JointDescription& joint = robot.joints[static_cast<std::size_t>(above)];
      const auto& leader = tree.leaders()[static_cast<std::size_t>(above)];
      const auto found = column.find(robot.joints[static_cast<std::size_t>(leader.joint)].name);
      if (found == column.end()) continue;
      const auto parent = static_cast<std::size_t>(tree.parent()[static_cast<std::size_t>(above)]);
      const geometry::RigidTransform X_RJ = X_RL[parent] * joint.X_PJ;
      const Eigen::Vector3d axis = X_RJ.linear() * joint.axis_J * leader.by.multiplier();
      if (joint.kind == JointDescription::Kind::kRevolute) {
        Jw.col(found->second) += axis;
        Jv.col(found->second) += axis.cross(X_RI.translation() - X_RJ.translation());
      } else if (joint.kind == JointDescription::Kind::kPrismatic) {
        Jv.col(found->second) += axis;
      }
    }
    const Eigen::Matrix3d I = X_RI.linear() * inertial->inertia * X_RI.linear().transpose();
    M += inertial->mass * Jv.transpose() * Jv + Jw.transpose() * I * Jw;
  }
  return M;
}

/// Within limits of a joint that has some, else within half a turn or a metre either way.
inline std::map<std::string, double> random_positions(const RobotDescription& robot,
                                                      std::mt19937& random) {
  std::map<std::string, double> positions;
  for (const JointDescription& joint : robot.joints) {
    if (!moves_by_itself(joint)) continue;
    const double unlimited =
        joint.kind == JointDescription::Kind::kRevolute ? std::numbers::pi : 1.0;
    const double lower = std::max(joint.lower.value_or(-unlimited), -10.0);
    const double upper = std::min(joint.upper.value_or(unlimited), 10.0);
    positions[joint.name] = lower + (upper - lower) * std::generate_canonical<double, 32>(random);
  }
  return positions;
}

}  // namespace prehend::robot::formats
