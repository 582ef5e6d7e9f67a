#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/surface/scalar_grid.h"

namespace prehend::surface {

/// Lowers `field` so that it is above `level` only within `margin` of the convex hull of `points`,
/// everything in nodes, and falls off with `slope` per node there. The nodes beside the hull are
/// found row by row, so that O(rows faces + nodes near the hull faces) is spent.
/// False, and nothing done, when the hull is thinner than a node: points in a plane have none.
bool cut_at_hull(ScalarGrid& field, const std::vector<Eigen::Vector3f>& points, float margin,
                 float level, float slope);

}  // namespace prehend::surface
