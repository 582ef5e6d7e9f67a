#pragma once

#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"

namespace prehend::perception {

/// What objects stand on that stand on each other: nothing floats, so one whose lowest seen points
/// are well over the table rests on what lies under it. Heights over `table_W` [m], one an object:
/// that of the top, as far as it is seen, of the object under this one's footprint and beside it;
/// 0 where the table carries it, or nothing under it was seen that could.
std::vector<double> support_heights(const std::vector<const geometry::PointCloud*>& clouds_W,
                                    const geometry::Plane& table_W);

}  // namespace prehend::perception
