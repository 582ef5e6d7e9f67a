#pragma once

#include <vector>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

struct ConvexPiecesOptions {
  /// Triangles to which the mesh is thinned before it is cut up; time grows with their square.
  /// >= 50.
  int max_triangles = 700;
  /// Deepest dent of a piece that is filled by its hull, as a fraction of the mesh's diagonal, > 0.
  double concavity = 0.02;
  int min_pieces = 1;           // >= 1
  int max_hull_vertices = 128;  // of one piece, 4..1000; a ball loses 5 % of its volume with 128
};

/// A few closed convex meshes that together approximate the solid bounded by `mesh`, by Bullet's
/// HACD (Mamou and Ghorbel, "A simple and efficient approach for 3D mesh approximate convex
/// decomposition", ICIP 2009). A mesh that is convex within `concavity` gives its hull. The pieces
/// are hulls of parts of the thinned surface, so they may overlap.
/// @throws geometry::InputError for an empty or non-finite mesh, or one without volume.
std::vector<geometry::TriangleMesh> convex_pieces(const geometry::TriangleMesh& mesh,
                                                  const ConvexPiecesOptions& options = {});

/// `mesh` thinned to about `max_triangles` by clustering vertices in cells of a grid (Rossignac and
/// Borrel, 1993): each vertex of the result is the mean of a cell's vertices. Closed meshes stay
/// without boundary, but thin parts may collapse. The mesh itself when it is small enough.
geometry::TriangleMesh thinned(const geometry::TriangleMesh& mesh, int max_triangles);

}  // namespace prehend::surface
