#pragma once

#include <vector>

#include "prehend/motion/ball_cover.h"

namespace prehend::motion {

/// Few balls that together hold a whole solid, its inside too: every point of `solid` is in a ball,
/// and no point of a ball is farther than `overshoot` [m] from the solid. The solid is cut into
/// small boxes; of balls about their centres and about points further in, each as large as it may
/// be, those are taken that hold most boxes that none holds yet, and are made as small as their
/// boxes allow. `solid`: closed, triangles outward; it need not be convex. Cost: that of clipping
/// each triangle to the boxes that it enters, and of some thousand balls times as many boxes: 5 to
/// 100 ms for a link.
/// @throws std::invalid_argument for an overshoot that is not positive; geometry::InputError for a
/// mesh without triangles or with NaN, or when more than 20000 boxes are needed.
std::vector<Ball> cover_solid(const geometry::TriangleMesh& solid, double overshoot);

}  // namespace prehend::motion
