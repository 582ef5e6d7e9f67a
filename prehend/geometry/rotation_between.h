#pragma once

#include <Eigen/Geometry>

namespace prehend::geometry {

/// The shortest rotation R with R `from` parallel to `to`, both of any finite length above 0. Where
/// they are opposite, some half turn. (Eigen's FromTwoVectors decides that case by a singular value
/// decomposition, which each file that calls it would compile for six seconds.)
/// @throws std::invalid_argument when a length is 0 or not finite.
Eigen::Quaterniond rotation_between(const Eigen::Vector3d& from, const Eigen::Vector3d& to);

}  // namespace prehend::geometry
