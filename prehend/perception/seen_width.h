#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"

namespace prehend::perception {

/// Sides [m] of the smallest rectangle on the plane round what lies over it, (narrower, wider): of
/// some points of a body, no more than its own. (0, 0) without points. O(n log n).
/// @param members indices of `cloud_C`'s points, all finite.
Eigen::Vector2d sides_over_plane(const geometry::PointCloud& cloud_C,
                                 const std::vector<int>& members, const geometry::Plane& plane_C);

}  // namespace prehend::perception
