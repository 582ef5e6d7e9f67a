#pragma once

#include <string>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// Length, width and height [m] of a mesh over a table: the longer and the shorter side of the
/// smallest rectangle about its footprint, and how far it rises over the plane. O(n log n).
/// @pre the mesh has vertices.
Eigen::Vector3d size_on_table(const geometry::TriangleMesh& mesh_W, const geometry::Plane& table_W);

/// "105 x 80 x 70 mm".
std::string size_text(const Eigen::Vector3d& size);

}  // namespace prehend::surface
