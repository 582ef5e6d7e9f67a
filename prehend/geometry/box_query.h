#pragma once

#include <Eigen/Core>

#include "prehend/geometry/rigid_transform.h"

namespace prehend::geometry {

class SurfaceQuery;

/// Whether a triangle (a, b, c) and a solid box about the origin, along the axes, with sides of 2
/// `half_size` share a point; touching counts. By separating axes (T. Akenine-Moller, "Fast 3D
/// triangle-box overlap testing", Journal of Graphics Tools 6(1), 2001); triangles without an area
/// are segments or points.
bool does_triangle_meet_box(const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                            const Eigen::Vector3d& c, const Eigen::Vector3d& half_size);

/// Whether a triangle of a surface and a solid box share a point. A box inside a closed surface
/// that meets no triangle does not: SurfaceQuery::contains() tells. The box is cut into cells of
/// some centimetres, of which those near the surface look for triangles.
/// @param X_WB of the box's middle, in the surface's frame
/// @param half_size of the box's sides [m], finite and >= 0
/// @throws std::invalid_argument for others
bool does_surface_meet_box(const SurfaceQuery& surface_W, const RigidTransform& X_WB,
                           const Eigen::Vector3d& half_size);

}  // namespace prehend::geometry
