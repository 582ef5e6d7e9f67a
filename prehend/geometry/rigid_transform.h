#pragma once

#include <Eigen/Geometry>

namespace prehend::geometry {

/// A pose X_AB: the pose of frame B measured in frame A, so that p_A = X_AB * p_B. Metres.
using RigidTransform = Eigen::Isometry3d;

/// The pose with rotation `q_AB` (normalised here) and origin `p_AoBo_A` [m].
inline RigidTransform make_transform(const Eigen::Quaterniond& q_AB,
                                     const Eigen::Vector3d& p_AoBo_A) {
  RigidTransform X_AB = RigidTransform::Identity();
  X_AB.linear() = q_AB.normalized().toRotationMatrix();
  X_AB.translation() = p_AoBo_A;
  return X_AB;
}

/// Pose of a camera's optical frame C (x right, y down, z forward) that stands at `eye_W` and looks
/// at `target_W` [m], image upright with respect to `up_W`.
/// @pre eye and target differ and the view direction is not parallel to `up_W`.
inline RigidTransform look_at(const Eigen::Vector3d& eye_W, const Eigen::Vector3d& target_W,
                              const Eigen::Vector3d& up_W = Eigen::Vector3d::UnitZ()) {
  const Eigen::Vector3d z = (target_W - eye_W).normalized();
  const Eigen::Vector3d x = z.cross(up_W).normalized();
  RigidTransform X_WC = RigidTransform::Identity();
  X_WC.linear() << x, z.cross(x), z;
  X_WC.translation() = eye_W;
  return X_WC;
}

}  // namespace prehend::geometry
