#pragma once

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"

/// Procedural watertight meshes. All stand on z = 0, centred on the z axis, triangles outward.
/// All lengths in metres. Each function throws std::invalid_argument naming the dimension that is
/// not finite and positive or does not fit the others.
namespace prehend::simulation {

/// Box of full side lengths `size`.
geometry::TriangleMesh make_standing_box(const Eigen::Vector3d& size);

/// Cylinder with bevelled rims (2 mm, or less for small cans).
geometry::TriangleMesh make_can(double radius, double height);

/// Bottle: body to 60 % of the height, round shoulder, neck of 40 % of the radius, cap.
geometry::TriangleMesh make_bottle(double radius, double height);

/// Cup with a hollow of wall thickness `wall` and a handle towards +x. Two closed parts that
/// overlap where the handle enters the wall.
geometry::TriangleMesh make_mug(double radius, double height, double wall = 0.004);

/// Spray bottle: body of elliptic section (`width` along x, `depth` along y), neck, head with a
/// nozzle towards +x and a trigger. Three closed parts that overlap.
geometry::TriangleMesh make_spray_bottle(double width, double depth, double height);

/// Ball resting on z = 0.
geometry::TriangleMesh make_ball(double radius);

}  // namespace prehend::simulation
