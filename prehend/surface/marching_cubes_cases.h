#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace prehend::surface {

/// What to do in a cube. Corner c is at (c & 1, c >> 1 & 1, c >> 2 & 1); edge e runs along axis
/// e / 4 from corner edge_corner(e) in the direction of increasing coordinate.
struct CubeCase {
  std::vector<std::array<std::int8_t, 3>> triangles;  // edges 0..11, or 12 + i: centre of loop i
  std::vector<std::vector<std::int8_t>> centered;     // loops of edges that need a centre vertex
};

/// The lower corner of edge `e`: those with a zero bit at its axis, in increasing order.
int edge_corner(int e);

/// One case for each set of inside corners (bit c: corner c is inside).
const std::array<CubeCase, 256>& cube_cases();

}  // namespace prehend::surface
