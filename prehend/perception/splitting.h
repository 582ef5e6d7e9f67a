#pragma once

#include <vector>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/point_cloud.h"

namespace prehend::perception {

/// Knobs of splitting clusters of touching objects.
struct SplitOptions {
  double patch = 0.012;      // m, side of the patch that a normal is estimated in
  double min_crease = 0.45;  // rad (26 deg) by which the surface must bend inwards at a border
  double min_share = 0.12;   // of the cluster's pixels, for a part to be an object of its own
  /// Parts of different objects differ in mean colour by this many grey levels (Euclidean, of the
  /// chromaticity and lightness of Lab). Only with colours; 0: the crease alone decides.
  double min_color_difference = 12;
};

/// Splits a cluster of an organized cloud where its surface bends inwards sharply, as it does where
/// one object stands on, leans against or touches another, but not at a convex edge (Stein et al.,
/// "Object partitioning using local convexity", CVPR 2014). Parts that are small or, where the
/// cloud has colours, of the same colour as their neighbour stay with it: a handle, a nozzle, a
/// body in one colour. So do ledges narrower than about 1.5 patches. A cluster that needs no split
/// comes back whole.
/// @param members pixels of the cluster. @returns disjoint parts that together are `members`,
/// ascending, largest first. O(members).
/// @throws std::invalid_argument for a cloud that is not organized or a bad option.
std::vector<std::vector<int>> split_touching(const geometry::PointCloud& cloud_C,
                                             const geometry::PinholeCamera& camera,
                                             const std::vector<int>& members,
                                             const SplitOptions& options = {});

}  // namespace prehend::perception
