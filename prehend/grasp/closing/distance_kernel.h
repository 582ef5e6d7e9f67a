#pragma once

#include <array>
#include <cstddef>
#include <span>

namespace prehend::grasp {

constexpr int kBlockSide = 4;  // nodes
/// Distances [m] at a block's nodes; x changes fastest.
using DistanceBlock = std::array<float, kBlockSide * kBlockSide * kBlockSide>;

/// A triangle, as vector instructions measure distances to it. All in m.
struct BlockTriangle {
  struct Side {
    float from[3], way[3];
    float per_squared = 0;  // 1 / m^2, of the side's length; 0: it has none
    float inward[3];        // unit, across the side in the triangle's plane
  };
  Side sides[3];
  float normal[3];  // unit
  float centroid[3];
  float radius = 0;       // round the centroid
  bool has_area = false;  // else it is its sides
};

/// Where a block is and what is known of it.
struct BlockPlace {
  float first[3];  // m, its first node
  float cell = 0;  // m, between nodes
  float most = 0;  // m: the surface is not farther from the block's middle
};

/// Distances from the block's nodes to the nearest of those of `triangles` that `near` names (at
/// least one), which must hold all that can be nearest to some node. `scratch`: of the caller's,
/// for 8 numbers each of `near`.
///
/// Each eighth of the block leaves out the triangles farther than d + 2 r from its middle, where d
/// is a bound of the middle's distance and r half of the eighth's diagonal; the rest are asked for
/// its eight nodes at once, with the machine's best vector instructions.
void measure_block(std::span<const BlockTriangle> triangles, std::span<const int> near,
                   const BlockPlace& place, float* scratch, DistanceBlock& block);

}  // namespace prehend::grasp
