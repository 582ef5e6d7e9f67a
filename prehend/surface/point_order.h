#pragma once

#include <vector>

#include <Eigen/Core>

namespace prehend::surface {

/// An order of `points` (indices into it) that depends on where they are alone and not on the order
/// they come in, so that sums along it are the same to the last bit; nearby points mostly follow
/// one another. Points at the same place are ordered by `attributes` (normals) when given: as many
/// as points, or none. What is equal in both is equal. O(n) for points that differ.
/// @pre points are finite.
std::vector<int> canonical_order(const std::vector<Eigen::Vector3f>& points,
                                 const std::vector<Eigen::Vector3f>& attributes = {});

}  // namespace prehend::surface
