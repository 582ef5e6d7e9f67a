#include "drivers/ft300/node/mounting.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace prehend::drivers::ft300 {

geometry::RigidTransform mounting_from(const std::vector<double>& values) {
  if (values.size() != 6 ||
      !std::ranges::all_of(values, [](double value) { return std::isfinite(value); })) {
    throw std::invalid_argument("the mounting must be six numbers: x y z [m] roll pitch yaw [rad]");
  }
  geometry::RigidTransform X_GS = geometry::RigidTransform::Identity();
  X_GS.translation() = Eigen::Vector3d(values[0], values[1], values[2]);
  X_GS.linear() = (Eigen::AngleAxisd(values[5], Eigen::Vector3d::UnitZ()) *
                   Eigen::AngleAxisd(values[4], Eigen::Vector3d::UnitY()) *
                   Eigen::AngleAxisd(values[3], Eigen::Vector3d::UnitX()))
                      .toRotationMatrix();
  return X_GS;
}

Measurement in_gripper_frame(const Measurement& measurement_S, const geometry::RigidTransform& X_GS,
                             bool inverted) {
  const double sign = inverted ? -1 : 1;
  const Eigen::Vector3d force =
      sign * (X_GS.linear() * Eigen::Vector3d(measurement_S.force.data()));
  const Eigen::Vector3d torque =
      sign * (X_GS.linear() * Eigen::Vector3d(measurement_S.torque.data())) +
      X_GS.translation().cross(force);
  return {{force.x(), force.y(), force.z()}, {torque.x(), torque.y(), torque.z()}};
}

}  // namespace prehend::drivers::ft300
