#pragma once

#include <cstddef>
#include <functional>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"

namespace prehend::perception {

struct PartOptions {
  double contact_height = 0.025;  // m, what begins higher does not stand on the table by itself
  double join_gap = 0.04;         // m, such a part belongs to a larger one within this distance
  double drop_height = 0.05;      // m, a part that hangs is dropped when it begins higher
  /// Two clusters may have one colour when hue and colour differ by no more (mean_color.h). A
  /// handle in the shadow of its pot takes on some of the table's hue.
  double most_hue_difference = 0.3;
  double most_color_difference = 60;  // grey levels
};

/// Which clusters are one object, and which are none.
struct JoinedParts {
  std::vector<std::vector<int>> objects;  // indices of points, ascending
  std::vector<std::vector<int>> hanging;
};

/// Puts together clusters that one object falls into when its middle is not seen:
///  - what floats over the table belongs to the nearest cluster of at least twice its size;
///  - what floats and a nearby smaller cluster that looks alike and cannot carry it, as it is not
///    under its middle, are one: what joins them was not seen;
///  - what stands within the outline of such a cluster belongs to it: crumbs of a face that is seen
///    at a grazing angle;
///  - the far inside wall of a bowl, pot or mug belongs to the near wall. It is told by its
///    footprint, which is hollow towards the camera (farthest in the middle), and by a nearer
///    cluster of the same width and the same rim height.
/// Nothing floats: what is seen to do so stands on parts that are hidden, and is an object, unless
/// it goes on beyond what was looked at and may hang there (a lamp, a monitor's edge).
/// @param points in the optical frame C (camera at the origin). @param clusters indices into them.
/// @param is_cut one a cluster: whether it goes on beyond the image or the space over the table.
/// @param look_alike whether two clusters may have one colour; empty: none has.
JoinedParts joined_parts(const std::vector<Eigen::Vector3f>& points,
                         const std::vector<std::vector<int>>& clusters,
                         const std::vector<char>& is_cut, const geometry::Plane& table_C,
                         const PartOptions& options,
                         const std::function<bool(std::size_t, std::size_t)>& look_alike = {});

}  // namespace prehend::perception
