#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/point_cloud.h"

namespace prehend::perception {

/// Mean colour of `members` of a cloud with colours, in OpenCV's 8-bit Lab (0..255 each).
Eigen::Vector3d mean_color(const geometry::PointCloud& cloud, const std::vector<int>& members);

/// How much the mean colours of two parts differ [grey levels, Euclidean in Lab]; infinity where
/// the cloud has no colours.
double color_difference(const geometry::PointCloud& cloud, const std::vector<int>& a,
                        const std::vector<int>& b);

/// The same for hue and saturation alone, which no shade changes: a* and b* over
/// L* + 16 (CIE 1976: 116 times the cube root of the luminance), since shade scales all tristimulus
/// values alike. Of unit 1; 0 where the cloud has no colours.
double hue_difference(const geometry::PointCloud& cloud, const std::vector<int>& a,
                      const std::vector<int>& b);

}  // namespace prehend::perception
