#pragma once

#include <vector>

#include <Eigen/Geometry>

#include "prehend/geometry/swept_space.h"
#include "prehend/shape/seen_space.h"
#include "prehend/surface/scalar_grid.h"

namespace prehend::surface {

/// Where no surface may be. What is pointed to outlives its use.
struct EmptySpace {
  std::vector<const shape::SeenSpace*> seen;    // what cameras looked through
  const geometry::SweptSpace* swept = nullptr;  // what was moved through without a touch
};

/// Lowers `field` so that it is above `level` nowhere that a camera looked through by more than a
/// tolerance: the larger of 5 mm and two nodes, since the seen surface itself is no exacter; and
/// nowhere that was swept, by more than a node. Thus what a surface bridges, the hole of a ring or
/// the space between two wings, stays open where it was found to be. The field falls off with
/// `slope` per node at the cut. `X_W_nodes` takes the grid's node coordinates to W [m].
/// O(nodes above the level).
void cut_at_empty_space(ScalarGrid& field, const EmptySpace& empty,
                        const Eigen::Affine3d& X_W_nodes, float level, float slope);

}  // namespace prehend::surface
