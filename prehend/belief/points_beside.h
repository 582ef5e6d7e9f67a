#pragma once

#include <cstddef>
#include <vector>

#include "prehend/geometry/point_cloud.h"

namespace prehend::belief {

/// Indices of the points of `cloud` that are farther than 6 mm from all of `known`, about `most` of
/// them spread evenly over all: what a look tells beside what another one told.
std::vector<std::size_t> points_beside(const geometry::PointCloud& cloud,
                                       const geometry::PointCloud& known, std::size_t most);

}  // namespace prehend::belief
