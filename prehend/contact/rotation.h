#pragma once

#include <cmath>

#include <Eigen/Geometry>

namespace prehend::contact {

/// The rotation by |vector| [rad] about `vector`; smooth at zero.
inline Eigen::Quaterniond rotation_by(const Eigen::Vector3d& vector) {
  const double angle = vector.norm();
  // sin(a/2)/a = 1/2 - a^2/48 + ...: below this angle two terms are exact to rounding.
  const double factor = angle < 1e-3 ? 0.5 - angle * angle / 48 : std::sin(0.5 * angle) / angle;
  const double cosine = angle < 1e-3 ? 1 - angle * angle / 8 : std::cos(0.5 * angle);
  return Eigen::Quaterniond(cosine, factor * vector.x(), factor * vector.y(), factor * vector.z())
      .normalized();
}

/// The rotation vector of `rotation` [rad], of length at most pi: inverse of rotation_by.
inline Eigen::Vector3d rotation_vector(const Eigen::Quaterniond& rotation) {
  const double sine = rotation.vec().norm();
  if (sine == 0) return Eigen::Vector3d::Zero();
  const double angle = 2 * std::atan2(sine, std::abs(rotation.w()));
  return std::copysign(angle / sine, rotation.w()) * rotation.vec();
}

}  // namespace prehend::contact
