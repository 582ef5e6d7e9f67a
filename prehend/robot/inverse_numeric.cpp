#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numbers>
#include <random>

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include "prehend/robot/inverse_collector.h"

#include "prehend/geometry/symmetric_solve.h"

namespace prehend::robot {

using Eigen::Matrix3d;
using geometry::RigidTransform;

void InverseKinematics::numeric(const RigidTransform& X_BT, Collector& found) const {
  const int n = chain_.size();
  const auto clamp = [this, n](Positions& q) {
    for (int i = 0; i < n; ++i) {
      const ChainJoint& joint = chain_.joints()[static_cast<std::size_t>(i)];
      q[i] = std::clamp(q[i], joint.lower, joint.upper);
    }
  };
  const auto error_at = [&](const Positions& q) {
    const RigidTransform X = chain_.forward(q);
    Eigen::Matrix<double, 6, 1> error;
    const Eigen::AngleAxisd rotation(Matrix3d(X_BT.linear() * X.linear().transpose()));
    error << X_BT.translation() - X.translation(), rotation.angle() * rotation.axis();
    return error;
  };
  std::mt19937_64 random(options_.seed);
  const auto uniform = [&random] { return static_cast<double>(random() >> 11) * 0x1.0p-53; };
  double least = std::numeric_limits<double>::infinity();
  for (int start = 0; start <= options_.restarts; ++start) {
    Positions q = found.seed;
    for (int i = 0; start > 0 && i < n; ++i) {
      const ChainJoint& joint = chain_.joints()[static_cast<std::size_t>(i)];
      const double low = std::isfinite(joint.lower) ? joint.lower : -std::numbers::pi;
      const double high = std::isfinite(joint.upper) ? joint.upper : std::numbers::pi;
      q[i] = low + (high - low) * uniform();
    }
    clamp(q);
    Eigen::Matrix<double, 6, 1> error = error_at(q);
    double damping = 1e-2;
    for (int step = 0; step < options_.iterations && damping < 1e8; ++step) {
      if (error.head<3>().norm() <= options_.tolerance &&
          error.tail<3>().norm() <= options_.tolerance) {
        found.add(q);
        return;
      }
      const auto J = chain_.jacobian(q);
      const Eigen::Matrix<double, 6, 6> normal =
          J * J.transpose() + damping * Eigen::Matrix<double, 6, 6>::Identity();
      Positions next = q + J.transpose() * geometry::symmetric_solve<6>(normal, error);
      clamp(next);
      const Eigen::Matrix<double, 6, 1> after = error_at(next);
      if (after.squaredNorm() < error.squaredNorm()) {
        q = next;
        error = after;
        damping = std::max(1e-14, damping / 10);
      } else {
        damping *= 4;
      }
    }
    least = std::min(least, error.head<3>().norm());
  }
  found.out_of_reach = least;
  found.failure = InverseFailure::kNotFound;
  char text[160];
  std::snprintf(text, sizeof text,
                "no solution was found from %d starts; the nearest was %.1f mm away",
                options_.restarts + 1, 1e3 * least);
  found.unreachable = text;
}

}  // namespace prehend::robot
