#include "prehend/grasp/generators/directions.h"

#include <cmath>

#include <Eigen/Geometry>

namespace prehend::grasp {

Eigen::Vector3d perpendicular_part(const Eigen::Vector3d& v, const Eigen::Vector3d& axis) {
  const Eigen::Vector3d part = v - v.dot(axis) * axis;
  return part.norm() < 1e-6 ? Eigen::Vector3d::Zero() : part.normalized();
}

Eigen::Matrix3d frame_about(const Eigen::Vector3d& z) {
  const Eigen::Vector3d helper =
      std::abs(z.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  Eigen::Matrix3d frame;
  frame.col(2) = z;
  frame.col(1) = z.cross(helper).normalized();
  frame.col(0) = frame.col(1).cross(z);
  return frame;
}

}  // namespace prehend::grasp
