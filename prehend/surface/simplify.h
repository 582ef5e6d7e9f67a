#pragma once

#include <cstddef>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// A mesh with fewer triangles, and how far it is from the one it stands for.
struct SimplifiedMesh {
  geometry::TriangleMesh mesh;
  double error = 0;  // m, by the quadrics of the collapsed edges (Garland and Heckbert 1997)
};

/// About `most_triangles` of `mesh`, by collapsing the edges that change it least; its vertices are
/// some of the mesh's, merged where they coincide. A mesh that has no more comes back with its
/// vertices merged. A watertight mesh stays so: it keeps two or four times as many triangles where
/// that takes it, all where that does not. O(n log n).
SimplifiedMesh simplified(const geometry::TriangleMesh& mesh, std::size_t most_triangles);

}  // namespace prehend::surface
