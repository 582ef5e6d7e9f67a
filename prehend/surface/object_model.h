#pragma once

#include <vector>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// The predicted solid.
struct ObjectModel {
  geometry::TriangleMesh mesh_W;
  geometry::MeshDefects defects;
  std::vector<geometry::TriangleMesh> convex_pieces_W;
  geometry::MassProperties mass_properties;  // in W
  double seen_deviation = 0;                 // mean distance of the seen points to the mesh [m]
};

}  // namespace prehend::surface
