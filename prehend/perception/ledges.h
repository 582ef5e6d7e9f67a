#pragma once

#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"

namespace prehend::perception {

/// Knobs of telling stacked and pushed-together things apart by their tops.
struct LedgeOptions {
  double cell = 0.004;             // m, of the map of heights, > 0
  double flatness = 0.0025;        // m by which neighbours in a level top differ at most
  double least_step = 0.008;       // m between two tops
  double least_height = 0.012;     // m of a ledge over the table: lower ones are the table's noise
  double least_plate = 2e-4;       // m^2 of a level top
  double least_width = 0.02;       // m of what rises over a ledge: narrower is a neck, a handle
  double least_level_share = 0.4;  // of what rises, that is level on top: a knob, a body is not
  /// Parts whose mean colours differ by less [grey levels, Euclidean in Lab] are one; only with
  /// colours. >= 0.
  double least_color_difference = 12;
  /// Nor may they be shades of one colour: their hues differ by this, too (mean_color.h), or the
  /// colours by five times the above. >= 0.
  double least_hue_difference = 0.09;
};

struct LedgePart {
  std::vector<int> members;  // indices of its points
  /// There is such a ledge in it, but the colours on either side are not two things': a stack of
  /// one colour, or one thing with a step.
  bool may_be_several = false;
};

/// Splits a cluster of points over `table_C` where a level ledge is beside something that rises
/// from it to a level top of its own: one box on another, or two of unequal heights side by side.
/// Whether what rises stands on the ledge or beside it is told by the points under the ledge's
/// height: the wall of one that stands beside goes on down. A hollow's floor is no ledge, a neck,
/// knob or handle no thing of its own. A rim (10 to 20 % of the area that rises) needs colours that
/// differ by twice the least. Under a ledge a wall must be seen, unless something taller before it
/// hides that. The camera is C's origin. Repeated on both parts: stacks of several. What is flush
/// in all directions, or round on top, stays whole.
/// @param members indices of the cluster's points. @returns disjoint parts that together are
/// `members`, largest first. O(members).
/// @throws std::invalid_argument for a bad option.
std::vector<LedgePart> split_at_ledges(const geometry::PointCloud& cloud_C,
                                       const geometry::Plane& table_C,
                                       const std::vector<int>& members,
                                       const LedgeOptions& options = {});

}  // namespace prehend::perception
