#pragma once

#include <vector>

#include "prehend/motion/ball_cover.h"

namespace prehend::motion {

/// Balls that together hold a whole solid, its inside too: every point of `solid` is in a ball, and
/// no point of a ball is farther than `overshoot` [m] from the solid. What of the solid is in a box
/// gets one ball where that reaches no farther, else the box is halved; so thick parts take few
/// balls. `solid`: closed, triangles outward; it need not be convex. Cost: that of clipping each
/// triangle to the boxes that it enters; a link of 1000 triangles takes about a millisecond.
/// @throws std::invalid_argument for an overshoot that is not positive; geometry::InputError for a
/// mesh without triangles or with NaN, or when more than 20000 balls are needed.
std::vector<Ball> cover_solid(const geometry::TriangleMesh& solid, double overshoot);

}  // namespace prehend::motion
