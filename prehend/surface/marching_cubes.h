#pragma once

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/surface/scalar_grid.h"

namespace prehend::surface {

/// The surface between the nodes of `field` above `level` (inside) and the others (outside), in the
/// grid's index coordinates, triangles facing outward (Lorensen and Cline, "Marching cubes",
/// SIGGRAPH 1987). Nodes on the grid's border count as outside, as does NaN. Empty when no node is
/// inside.
///
/// The mesh is always closed and manifold, whatever the field: every edge has exactly two triangles
/// that run along it in opposite directions, and the triangles round every vertex form one ring.
/// - Each crossed grid edge has one vertex, strictly between its nodes.
/// - On a face of a cube the crossings are joined by a rule that knows the face's four signs only
///   (nodes inside are cut off one by one when they lie across), so both cubes of the face agree.
/// - A crossed edge lies on two faces of each of its four cubes, so in each cube it is passed by
///   one loop, once, and the four pieces close into a ring.
/// - Loops are cut into triangles by diagonals that lie on no face of the cube, or from the loop's
///   centre where there are none, so that no diagonal can meet one of another cube.
/// O(nodes) to look, O(triangles) to make.
geometry::TriangleMesh marching_cubes(const ScalarGrid& field, float level);

}  // namespace prehend::surface
