#include "prehend/contact/pad_contact.h"

#include <Eigen/Geometry>

#include "prehend/contact/rotation.h"

namespace prehend::contact {

Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

geometry::RigidTransform PadPlacement::X_PW() const {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = R_WP.transpose();
  X.translation() = -(X.linear() * p_WP);
  return X;
}

geometry::RigidTransform PadPlacement::X_WP_at_end(const PadMount& mount,
                                                   const Eigen::Matrix3d& R_WG_end, double h,
                                                   double slide_velocity) const {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = R_WG_end * mount.X_GP.linear();
  X.translation() = p_WP + h * (carrier_linear + slide_velocity * direction_W);
  return X;
}

PadPlacement place_pad(const PadMount& mount, const geometry::RigidTransform& X_WG_end,
                       const Eigen::Vector3d& velocity_end, const Eigen::Vector3d& angular_velocity,
                       double slide_position, double h) {
  const Eigen::Matrix3d back = rotation_by(-h * angular_velocity).toRotationMatrix();
  const Eigen::Vector3d arm =
      X_WG_end.linear() * (mount.X_GP.translation() + slide_position * mount.direction_G);
  PadPlacement pad;
  pad.carrier_linear = velocity_end + angular_velocity.cross(arm);
  pad.angular_W = angular_velocity;
  pad.p_WP = X_WG_end.translation() + arm - h * pad.carrier_linear;
  pad.R_WP = back * X_WG_end.linear() * mount.X_GP.linear();
  pad.direction_W = X_WG_end.linear() * mount.direction_G;
  return pad;
}

Vector6 relative_twist(const PadMount& mount, const PadPlacement& pad, double slide_velocity,
                       const Eigen::Vector3d& velocity, const Eigen::Vector3d& angular_velocity,
                       const Eigen::Vector3d& p_WB) {
  Vector6 twist;
  Eigen::Vector3d linear = velocity + angular_velocity.cross(pad.p_WP - p_WB) - pad.carrier_linear;
  if (mount.slide >= 0) linear -= slide_velocity * pad.direction_W;
  twist.head<3>() = pad.R_WP.transpose() * linear;
  twist.tail<3>() = pad.R_WP.transpose() * (angular_velocity - pad.angular_W);
  return twist;
}

PadBlocks pad_blocks(const PadPlacement& pad, const PadResponse& response, double h,
                     const Eigen::Vector3d& p_WB) {
  // Into the world's axes, still about P's origin.
  const Eigen::Matrix3d& R = pad.R_WP;
  Matrix6 A;
  A.topLeftCorner<3, 3>() = R * response.resistance.topLeftCorner<3, 3>() * R.transpose();
  A.topRightCorner<3, 3>() = R * response.resistance.topRightCorner<3, 3>() * R.transpose();
  A.bottomRightCorner<3, 3>() = R * response.resistance.bottomRightCorner<3, 3>() * R.transpose();
  A.bottomLeftCorner<3, 3>() = A.topRightCorner<3, 3>().transpose();
  Vector6 wrench;
  wrench.head<3>() = R * response.constant.head<3>();
  wrench.tail<3>() = R * response.constant.tail<3>();
  Vector6 carrier;
  carrier << pad.carrier_linear, pad.angular_W;
  wrench += A * carrier;

  // T moves a twist from p_WB to P's origin.
  const Eigen::Matrix3d S = cross_matrix(pad.p_WP - p_WB);
  Matrix6 AT = A;
  AT.rightCols<3>() -= A.leftCols<3>() * S;
  PadBlocks blocks;
  Matrix6 TAT = AT;
  TAT.bottomRows<3>() += S * AT.topRows<3>();
  blocks.body_body = h * TAT;
  blocks.body_right.head<3>() = h * wrench.head<3>();
  blocks.body_right.tail<3>() = h * (wrench.tail<3>() + S * wrench.head<3>());
  const Eigen::Vector3d& d = pad.direction_W;
  blocks.slide_slide = h * d.dot(A.topLeftCorner<3, 3>() * d);
  blocks.slide_right = h * d.dot(wrench.head<3>());
  blocks.slide_body = h * d.transpose() * AT.topRows<3>();
  return blocks;
}

}  // namespace prehend::contact
