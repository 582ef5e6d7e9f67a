#pragma once

#include <cstddef>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// Points of either mesh of which the error is measured.
inline constexpr int kErrorPoints = 50'000;

/// A mesh with fewer triangles, and how far it is from the one it stands for.
struct SimplifiedMesh {
  geometry::TriangleMesh mesh;
  /// m, measured: the farthest of kErrorPoints, spread uniformly over either mesh, from the other.
  double error = 0;
};

/// About `most_triangles` of `mesh`, by collapsing the edges that change it least (meshoptimizer,
/// by the quadrics of Garland and Heckbert, 1997); its vertices are some of the mesh's, merged
/// where they coincide, and with_cut_edges() keeps a watertight mesh so. A mesh that has no more
/// triangles comes back with its vertices merged. Cost: O(n log n), 2 million triangles about 1.5 s
/// of processor time in two threads, a third of it for the error.
SimplifiedMesh simplified(const geometry::TriangleMesh& mesh, std::size_t most_triangles);

}  // namespace prehend::surface
