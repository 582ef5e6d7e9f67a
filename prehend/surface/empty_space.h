#pragma once

#include <Eigen/Geometry>

#include "prehend/shape/seen_space.h"
#include "prehend/surface/scalar_grid.h"

namespace prehend::surface {

/// Lowers `field` so that it is above `level` nowhere that a camera looked through by more than a
/// tolerance: the larger of 5 mm and two nodes, since the seen surface itself is no exacter. Thus
/// what a surface bridges, the hole of a ring or the space between two wings, stays open where it
/// was seen to be. The field falls off with `slope` per node at the cut. `X_C_nodes` takes the
/// grid's node coordinates to the camera's optical frame [m]. O(nodes above the level).
void cut_at_empty_space(ScalarGrid& field, const shape::SeenSpace& space,
                        const Eigen::Affine3d& X_C_nodes, float level, float slope);

}  // namespace prehend::surface
