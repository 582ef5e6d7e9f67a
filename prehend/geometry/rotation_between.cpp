#include "prehend/geometry/rotation_between.h"

#include <cmath>
#include <stdexcept>

namespace prehend::geometry {

Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  const double from_length = from.stableNorm(), to_length = to.stableNorm();
  if (!(from_length > 0 && std::isfinite(from_length) && to_length > 0 &&
        std::isfinite(to_length))) {
    throw std::invalid_argument("rotation_between: a direction is zero or not finite");
  }
  const Eigen::Vector3d a = from / from_length, b = to / to_length;
  // 1 + a.b without cancellation.
  const double real = (a + b).squaredNorm() / 2;
  const Eigen::Vector3d imaginary = a.cross(b);
  if (real < 1e-24) {
    const Eigen::Vector3d axis = a.unitOrthogonal();
    return {0, axis.x(), axis.y(), axis.z()};
  }
  return Eigen::Quaterniond(real, imaginary.x(), imaginary.y(), imaginary.z()).normalized();
}

}  // namespace prehend::geometry
