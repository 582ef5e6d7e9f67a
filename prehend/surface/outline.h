#pragma once

#include <vector>

#include <Eigen/Core>

namespace prehend::surface {

/// Indices of the corners of the convex hull of `points` [m], counter-clockwise, by Andrew's
/// monotone chain ("Another efficient algorithm for convex hulls in two dimensions", 1979); empty
/// when there are fewer than three corners. O(n log n).
std::vector<int> convex_outline(const std::vector<Eigen::Vector2d>& points);

/// True when `p` is within the counter-clockwise convex `outline` or on it.
bool contains(const std::vector<Eigen::Vector2d>& outline, const Eigen::Vector2d& p);

}  // namespace prehend::surface
