#pragma once

#include <Eigen/Core>

// Rows that take a body's twist (velocity of its origin, angular velocity; world) elsewhere.
namespace prehend::simulation::engines {

using PointRows = Eigen::Matrix<double, 3, 6>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

inline Eigen::Matrix3d cross_matrix(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
  return m;
}

/// From a twist about the body's origin to the velocity of a point at `arm` from it.
inline PointRows point_rows(const Eigen::Vector3d& arm) {
  PointRows rows;
  rows << Eigen::Matrix3d::Identity(), -cross_matrix(arm);
  return rows;
}

/// The same, with the angular velocity, and into axes of R's frame.
inline Matrix6 frame_rows(const Eigen::Vector3d& arm, const Eigen::Matrix3d& R) {
  Matrix6 rows = Matrix6::Zero();
  rows.topRows<3>() = R.transpose() * point_rows(arm);
  rows.bottomRightCorner<3, 3>() = R.transpose();
  return rows;
}

}  // namespace prehend::simulation::engines
