#pragma once

#include <vector>

#include "prehend/geometry/point_cloud.h"

namespace prehend::perception {

/// Connected components of pixels of an organized cloud: two of the pixels named by `indices` are
/// joined when they are at most `reach` columns and rows apart and their points at most
/// `tolerance` [m]. What Euclidean clustering (euclidean_clusters) finds, unless its groups touch
/// across more than `reach` pixels of unknown or other points; O(n reach^2), ten times faster.
/// Indices ascending; largest component first, ties by first index; those with fewer than
/// `min_size` are left out.
/// @throws std::invalid_argument when the cloud is not organized, reach is not 1..20 or tolerance
/// not positive. @pre the named points are finite.
std::vector<std::vector<int>> organized_components(const geometry::PointCloud& cloud,
                                                   const std::vector<int>& indices,
                                                   double tolerance, int reach, int min_size);

/// Those of the pixels named by `indices` of an organized cloud that are no flying points: of the
/// points within two columns and rows, two or more are within `tolerance` [m] and twice a pixel's
/// width at that depth (a slanted surface of a coarse picture). Where fewer than eight of those
/// pixels have a point, nothing can be told, and it stays. A thread one pixel wide stays, too.
/// Order kept; O(n). @param focal_length of the camera [pixels], > 0.
/// @throws std::invalid_argument when the cloud is not organized or tolerance not positive.
/// @pre the named points are finite.
std::vector<int> without_flying_points(const geometry::PointCloud& cloud,
                                       const std::vector<int>& indices, double tolerance,
                                       double focal_length);

}  // namespace prehend::perception
