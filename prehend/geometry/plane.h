#pragma once

#include <Eigen/Core>

namespace prehend::geometry {

/// The plane {p : normal · p = offset}; `normal` is a unit vector, `offset` in metres. A table's
/// normal points away from the table towards the objects on it.
struct Plane {
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();
  double offset = 0;

  /// Height of `p` over the plane along the normal [m].
  double signed_distance(const Eigen::Vector3d& p) const { return normal.dot(p) - offset; }
  /// The point of the plane nearest to `p`.
  Eigen::Vector3d project(const Eigen::Vector3d& p) const {
    return p - signed_distance(p) * normal;
  }
};

}  // namespace prehend::geometry
