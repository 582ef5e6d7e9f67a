#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/robot/robot_model.h"

namespace prehend::robot {

/// A moving joint of a chain.
struct ChainJoint {
  std::string name;
  bool is_revolute = true;
  /// From the frame after the joint before (the base's, for the first) to this joint's at position
  /// 0. Fixed joints are folded in.
  geometry::RigidTransform X_PJ = geometry::RigidTransform::Identity();
  Eigen::Vector3d axis_J = Eigen::Vector3d::UnitZ();  // unit
  double lower = 0, upper = 0;                        // rad or m; may be infinite
  double max_velocity = 0;                            // rad/s or m/s; may be infinite
};

constexpr int kMostChainJoints = 16;
/// Positions of a chain's joints [rad or m], without memory of their own.
using Positions = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostChainJoints, 1>;

/// The joints between two links, from base B to tip T; at most kMostChainJoints. Positions q are in
/// their order, in rad and m. Reentrant.
class KinematicChain {
 public:
  /// @throws geometry::InputError when a link is not there, the tip is not below the base, no joint
  /// between them moves, more than kMostChainJoints do, or one mimics another.
  KinematicChain(const RobotModel& model, const std::string& base, const std::string& tip);

  int size() const { return static_cast<int>(joints_.size()); }
  const std::vector<ChainJoint>& joints() const { return joints_; }
  /// From the last joint's frame to the tip.
  const geometry::RigidTransform& X_JT() const { return X_JT_; }

  /// Pose of the tip in the base. @pre q has size() entries, as in all that follows.
  geometry::RigidTransform forward(const Eigen::Ref<const Eigen::VectorXd>& q) const;
  /// Poses X_BJ of the frames after each joint; `poses` is resized.
  void forward(const Eigen::Ref<const Eigen::VectorXd>& q,
               std::vector<geometry::RigidTransform>& poses) const;
  /// 6 x size(): linear velocity of the tip's origin (rows 0 to 2) and angular velocity (rows 3 to
  /// 5), both in the base frame, for each joint's velocity.
  Eigen::Matrix<double, 6, Eigen::Dynamic> jacobian(
      const Eigen::Ref<const Eigen::VectorXd>& q) const;

  /// Whether every position is within its joint's limits, widened by `tolerance` [rad or m].
  bool within_limits(const Eigen::Ref<const Eigen::VectorXd>& q, double tolerance = 1e-9) const;
  /// "joint 'elbow' at 134.2 deg is beyond 120.0 deg"; empty when within_limits(q).
  std::string limit_problem(const Eigen::Ref<const Eigen::VectorXd>& q) const;
  /// Middle of the limits; 0 where there are none.
  Positions middle() const;

 private:
  std::vector<ChainJoint> joints_;
  geometry::RigidTransform X_JT_ = geometry::RigidTransform::Identity();
};

}  // namespace prehend::robot
