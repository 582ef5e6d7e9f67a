#pragma once

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::grasp {

/// An object to grasp: its surface with outward triangles, and what it weighs.
struct Solid {
  geometry::TriangleMesh mesh_W;
  Eigen::Vector3d center_of_mass_W = Eigen::Vector3d::Zero();
  double mass = 0;    // kg
  double radius = 0;  // m, largest distance of the surface to the centre of mass
};

/// Triangles of an inside-out mesh are turned; the mass is that of the mesh, of its convex hull
/// where it is not watertight, with `density` [kg/m^3].
/// @throws geometry::InputError for a mesh without triangles or volume, with NaN or bad indices.
Solid make_solid(const geometry::TriangleMesh& mesh_W, double density);

}  // namespace prehend::grasp
