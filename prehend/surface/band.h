#pragma once

#include <cstddef>
#include <vector>

#include <Eigen/Core>

namespace prehend::surface {

/// A row of neighbouring nodes along x.
struct NodeRun {
  int x;
  int y;
  int z;
  int length;
};

/// The nodes of a grid of `size` that are within `reach` nodes along each axis of the cells that
/// hold `points` [nodes], as runs in the order of the nodes; never a node on the grid's border.
std::vector<NodeRun> band_about(const std::vector<Eigen::Vector3f>& points,
                                const Eigen::Vector3i& size, int reach);

}  // namespace prehend::surface
