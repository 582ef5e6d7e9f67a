#pragma once

#include <Eigen/Core>

namespace prehend::grasp {

/// The vector's part perpendicular to the unit vector `axis`, normalised; zero when parallel.
Eigen::Vector3d perpendicular_part(const Eigen::Vector3d& v, const Eigen::Vector3d& axis);

/// A right-handed frame with the unit vector `z` as its third axis.
Eigen::Matrix3d frame_about(const Eigen::Vector3d& z);

}  // namespace prehend::grasp
