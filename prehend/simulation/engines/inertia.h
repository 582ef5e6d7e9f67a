#pragma once

#include <Eigen/Core>

#include "prehend/simulation/engines/engine.h"

namespace prehend::simulation::engines {

/// Inertia of the homogeneous solid about its centre [kg m^2]: principal moments along B's axes.
inline Eigen::Vector3d principal_inertia(const EngineShape& shape, double mass) {
  const double r2 = shape.radius * shape.radius, l = shape.length;
  switch (shape.kind) {
    case EngineShape::Kind::kBox: {
      const Eigen::Vector3d s = shape.size.cwiseAbs2();
      return mass / 12 * Eigen::Vector3d(s.y() + s.z(), s.x() + s.z(), s.x() + s.y());
    }
    case EngineShape::Kind::kSphere:
      return Eigen::Vector3d::Constant(0.4 * mass * r2);
    case EngineShape::Kind::kCylinder: {
      const double across = mass * (3 * r2 + l * l) / 12;
      return {across, across, 0.5 * mass * r2};
    }
    case EngineShape::Kind::kCapsule: {
      // A cylinder and two half balls whose centres of mass are 3/8 r beyond its ends.
      const double balls = mass * (4.0 / 3 * shape.radius) / (l + 4.0 / 3 * shape.radius);
      const double tube = mass - balls;
      const double across = tube * (3 * r2 + l * l) / 12 +
                            balls * (0.4 * r2 + 0.25 * l * l + 0.375 * l * shape.radius);
      return {across, across, 0.5 * tube * r2 + 0.4 * balls * r2};
    }
    case EngineShape::Kind::kConvexPieces:
      break;  // may overlap: a body of pieces has its moments given
  }
  return Eigen::Vector3d::Zero();
}

/// That of a body: as given, or of its shape.
inline Eigen::Vector3d principal_inertia(const EngineBody& body) {
  return body.moments.isZero(0) ? principal_inertia(body.shape, body.mass) : body.moments;
}

}  // namespace prehend::simulation::engines
