#pragma once

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// The same surface, with two triangles at each edge where as many run along it one way as the
/// other: pairs of triangles that lie on each other face to face are dropped, and where more than
/// two still meet, each pair gets a vertex of its own in the edge's middle. So what bounds a solid
/// but for pinched and folded places, as collapsed edges leave them, becomes watertight. Vertices
/// keep their places, new ones come behind them. O(n log n).
geometry::TriangleMesh with_cut_edges(const geometry::TriangleMesh& mesh);

}  // namespace prehend::surface
