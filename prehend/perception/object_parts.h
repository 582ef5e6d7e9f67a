#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"

namespace prehend::perception {

struct PartOptions {
  double contact_height = 0.025;  // m, what begins higher does not stand on the table by itself
  double join_gap = 0.04;         // m, such a part belongs to a larger one within this distance
  double drop_height = 0.05;      // m, a part without one is dropped when it begins higher
};

/// Puts together clusters that one object falls into when its middle is not seen:
///  - what floats over the table belongs to the nearest cluster of at least twice its size;
///  - the far inside wall of a bowl, pot or mug belongs to the near wall. It is told by its
///    footprint, which is hollow towards the camera (farthest in the middle), and by a nearer
///    cluster of the same width and the same rim height.
/// Clusters hanging in the air (a lamp, a monitor's edge) are dropped.
/// @param points in the optical frame C (camera at the origin). @param clusters indices into them.
std::vector<std::vector<int>> joined_parts(const std::vector<Eigen::Vector3f>& points,
                                           const std::vector<std::vector<int>>& clusters,
                                           const geometry::Plane& table_C,
                                           const PartOptions& options);

}  // namespace prehend::perception
