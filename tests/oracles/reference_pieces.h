#pragma once

#include <vector>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// References for convex_pieces(), which is faster and keeps to a stated error.
struct HacdOptions {
  /// Triangles to which the mesh is thinned before it is cut up; time grows with their square.
  /// >= 50.
  int max_triangles = 700;
  double concavity = 0.02;      // of a cluster, as a fraction of the mesh's diagonal, > 0
  int max_hull_vertices = 128;  // of one piece, 8..1000
};

/// Hulls of clusters of triangles by Bullet's HACD (Mamou and Ghorbel, "A simple and efficient
/// approach for 3D mesh approximate convex decomposition", ICIP 2009). HACD prints its progress on
/// standard output. @throws geometry::InputError for an empty or non-finite mesh, or one without
/// volume.
std::vector<geometry::TriangleMesh> hacd_pieces(const geometry::TriangleMesh& mesh,
                                                const HacdOptions& options = {});

/// Pieces by Bullet's ConvexDecomposition (John Ratcliff): the mesh is cut by planes `depth` times
/// over while a part's volume is less than its hull's by more than `concave_percent`.
/// @throws geometry::InputError as hacd_pieces().
std::vector<geometry::TriangleMesh> ratcliff_pieces(const geometry::TriangleMesh& mesh,
                                                    int depth = 5, double concave_percent = 5);

/// `mesh` thinned to about `max_triangles` by clustering vertices in cells of a grid (Rossignac and
/// Borrel, 1993): each vertex of the result is the mean of a cell's vertices. Closed meshes stay
/// without boundary, but thin parts may collapse. The mesh itself when it is small enough.
geometry::TriangleMesh thinned(const geometry::TriangleMesh& mesh, int max_triangles);

}  // namespace prehend::surface
