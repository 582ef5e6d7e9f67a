#pragma once

#include <vector>

#include "prehend/shape/completed_shape.h"

namespace prehend::shape {

/// Keeps completed bodies that stand beside each other out of one another: of two whose predicted
/// parts overlap, each ends at an upright plane between what was seen of them: at that one of all
/// such planes beyond which least was predicted (the least sum of both bodies' mean distances by
/// which predicted points lie beyond it). The predicted points beyond it go, those of alternatives
/// too, and `bounds_W` of both says so. Seen points stay.
/// Bodies between which no such plane lies within 3 mm, and those of which one was seen to begin
/// where the other ends, since it stands on it, are left as they are. O(n^2) in the shapes.
void keep_apart(const std::vector<CompletedShape*>& shapes, const geometry::Plane& table_W);

}  // namespace prehend::shape
