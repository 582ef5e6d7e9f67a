#pragma once

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
/// @pre there is a point.
template <class Scalar>
std::set<std::size_t> extremes_of(const std::vector<Eigen::Vector3<Scalar>>& points,
                                  const std::vector<Eigen::Vector3<Scalar>>& directions) {
  std::set<std::size_t> chosen;
  for (const Eigen::Vector3<Scalar>& direction : directions) {
    std::size_t best = 0;
    Scalar most = direction.dot(points[0]);
    for (std::size_t i = 1; i < points.size(); ++i) {
      const Scalar along = direction.dot(points[i]);
      if (along > most) {
        most = along;
        best = i;
      }
    }
    chosen.insert(best);
  }
  return chosen;
}

}  // namespace prehend::surface
