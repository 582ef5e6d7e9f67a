#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <set>
#include <vector>

#include <Eigen/Core>

namespace prehend::surface {

/// `count` unit vectors spread over the sphere by the golden angle.
template <class Scalar>
std::vector<Eigen::Vector3<Scalar>> spread_directions(std::size_t count) {
  std::vector<Eigen::Vector3<Scalar>> directions;
  const double golden = 2.399963229728653;  // rad
  for (std::size_t i = 0; i < count; ++i) {
    const double z = 1 - (2 * static_cast<double>(i) + 1) / static_cast<double>(count);
    const double r = std::sqrt(1 - z * z);
    const double angle = golden * static_cast<double>(i);
    directions.push_back(
        Eigen::Vector3d(r * std::cos(angle), r * std::sin(angle), z).template cast<Scalar>());
  }
  return directions;
}

/// Indices of the points farthest along each of `directions`, the first of equals.
/// @pre there is a point; all are finite.
template <class Scalar>
std::set<std::size_t> extremes_of(const std::vector<Eigen::Vector3<Scalar>>& points,
                                  const std::vector<Eigen::Vector3<Scalar>>& directions) {
  // Coordinate by coordinate, so that many points are looked at at once.
  const std::size_t count = points.size();
  std::vector<Scalar> x(count), y(count), z(count), along(count);
  for (std::size_t i = 0; i < count; ++i) {
    x[i] = points[i].x();
    y[i] = points[i].y();
    z[i] = points[i].z();
  }
  std::set<std::size_t> chosen;
  for (const Eigen::Vector3<Scalar>& direction : directions) {
    for (std::size_t i = 0; i < count; ++i) {
      along[i] = direction.x() * x[i] + direction.y() * y[i] + direction.z() * z[i];
    }
    const Scalar most =
        Eigen::Map<const Eigen::ArrayX<Scalar>>(along.data(), static_cast<Eigen::Index>(count))
            .maxCoeff();
    const auto best = std::find(along.begin(), along.end(), most);
    chosen.insert(static_cast<std::size_t>(best - along.begin()));
  }
  return chosen;
}

}  // namespace prehend::surface
