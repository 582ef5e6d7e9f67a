#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "prehend/geometry/rigid_transform.h"

namespace prehend::motion {

/// A convex body in a frame S of its own.
struct ConvexBody {
  enum class Kind { kBox, kSphere, kCylinder, kPoints };
  Kind kind = Kind::kBox;
  Eigen::Vector3d size = Eigen::Vector3d::Zero();  // m, full sides of a box about the origin
  double radius = 0;                               // m, of a sphere or cylinder about the origin
  double length = 0;                               // m, of a cylinder, along z
  /// kPoints: the body is their convex hull, which has a volume.
  std::shared_ptr<const std::vector<Eigen::Vector3d>> points;
};

/// The body's largest p · `direction_S` over all of its points p [m for a unit direction].
inline double support(const ConvexBody& body, const Eigen::Vector3d& direction_S) {
  switch (body.kind) {
    case ConvexBody::Kind::kBox:
      return direction_S.cwiseAbs().dot(body.size) / 2;
    case ConvexBody::Kind::kSphere:
      return body.radius * direction_S.norm();
    case ConvexBody::Kind::kCylinder:
      return body.radius * direction_S.head<2>().norm() +
             std::abs(direction_S.z()) * body.length / 2;
    case ConvexBody::Kind::kPoints:
      break;
  }
  double most = -std::numeric_limits<double>::infinity();
  for (const Eigen::Vector3d& p : *body.points) most = std::max(most, direction_S.dot(p));
  return most;
}

/// How far `b` is from `a` along the unit vector `direction_B` [m]: never more than their distance,
/// and their distance where the direction is that of the nearest points. Negative: no answer.
inline double separation(const ConvexBody& a, const geometry::RigidTransform& X_BA,
                         const ConvexBody& b, const geometry::RigidTransform& X_BB,
                         const Eigen::Vector3d& direction_B) {
  return direction_B.dot(X_BB.translation() - X_BA.translation()) -
         support(a, X_BA.linear().transpose() * direction_B) -
         support(b, X_BB.linear().transpose() * -direction_B);
}

}  // namespace prehend::motion
