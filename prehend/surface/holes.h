#pragma once

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// What close_holes did.
struct ClosedHoles {
  int holes = 0;
  double area = 0;  // m^2, of the new triangles
};

/// Closes every hole whose border is a simple loop with a fan of triangles round the loop's centre.
/// The fans continue the orientation of the triangles they join. Loops that meet in a vertex are
/// left open. Vertices of `mesh` keep their indices.
ClosedHoles close_holes(geometry::TriangleMesh& mesh);

}  // namespace prehend::surface
