#pragma once

#include <vector>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

struct ConvexPiecesOptions {
  /// No point of a piece is farther than this from the solid [m], > 0: how deep a dent may be
  /// filled. As measured in voxels of two thirds of it.
  double concavity = 0.004;
  /// Most voxels along the solid's longest side, 16..128, which bounds time and what concavity can
  /// be kept: 1.5 extents / max_voxels, or a result says that it was not.
  int max_voxels = 48;
  int max_pieces = 64;          // 1..1000
  int max_hull_vertices = 128;  // of one piece, 8..1000; a ball loses 5 % of its volume with 128
};

struct ConvexPieces {
  std::vector<geometry::TriangleMesh> pieces;  // closed, convex; they may overlap
  double concavity = 0;  // reached: the farthest a point of a piece is from the solid [m]
};

/// A few closed convex meshes that cover the solid bounded by the closed `mesh` and reach no
/// farther than `concavity` beyond it.
///
/// The solid is cut into boxes of voxels, in the spirit of Mamou and Ghorbel ("A simple and
/// efficient approach for 3D mesh approximate convex decomposition", ICIP 2009) and V-HACD: while
/// the hull of the solid's part in a box holds voxels that are too far from the solid, the box with
/// the deepest one is cut by the plane, of those along the axes through that voxel, through the
/// solid's voxel nearest to it and through the middle, that leaves the least of the sum of the
/// distances of the voxels in the two new hulls and of a term for halves of unequal size. Then
/// pairs of parts are joined again while the common hull is within `concavity`. A piece is the hull
/// of the mesh's triangles clipped to the part's boxes, so the pieces cover the mesh, but for what
/// `max_hull_vertices` cuts off. Works in a frame of the mesh; deterministic.
/// @throws geometry::InputError for an empty or non-finite mesh, or one without volume.
/// @throws std::invalid_argument naming an option out of range.
ConvexPieces convex_pieces(const geometry::TriangleMesh& mesh,
                           const ConvexPiecesOptions& options = {});

}  // namespace prehend::surface
