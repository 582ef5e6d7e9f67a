#pragma once

#include <vector>

#include "prehend/geometry/triangle_mesh.h"
#include "prehend/shape/completed_shape.h"
#include "prehend/surface/object_model.h"

namespace prehend::surface {

/// What the vertices of a mesh rest on: one entry per vertex.
struct VertexBasis {
  std::vector<SurfaceOrigin> origin;
  std::vector<float> confidence;  // 0..1
};

/// What the vertices of `mesh_W`, made of `shape`, rest on. Counted in cells of the side `spacing`
/// [m]: a seen point in a vertex's cell or one beside it decides, else a predicted one there, else
/// either kind two cells away; where there is none, the surface is assumed. A vertex is as sure as
/// the surest point of that kind and distance, an assumed one half as sure as the whole shape.
/// O(vertices + points).
/// @throws std::invalid_argument for a spacing that is not positive, or so small that the shape is
/// 10 000 cells long, or a shape without a confidence for each point.
VertexBasis vertex_basis(const geometry::TriangleMesh& mesh_W, const shape::CompletedShape& shape,
                         double spacing);

/// The part of the mesh's area that nobody has seen or touched, 0..1: each triangle counts a third
/// for each vertex that is_guessed(). @pre one origin per vertex.
double guessed_area(const geometry::TriangleMesh& mesh, const std::vector<SurfaceOrigin>& origins);

}  // namespace prehend::surface
