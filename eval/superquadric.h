#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval {

/// The solid F(p) <= 1 with, in its own frame S,
///
///     F = ((x/a1)^(2/e2) + (y/a2)^(2/e2))^(e2/e1) + (z/a3)^(2/e1)
///
/// (A. Barr, "Superquadrics and Angle-Preserving Transformations", 1981): e1, e2 near 0 make a box,
/// e1 near 0 with e2 = 1 a cylinder, 1 and 1 an ellipsoid, 2 and 2 an octahedron.
struct Superquadric {
  geometry::RigidTransform X_WS = geometry::RigidTransform::Identity();
  Eigen::Vector3d half_sizes = Eigen::Vector3d::Ones();  // a1, a2, a3 [m], > 0
  double e1 = 1, e2 = 1;                                 // kLeastExponent..kMostExponent

  static constexpr double kLeastExponent = 0.1, kMostExponent = 2;

  /// From p to the surface along the ray from the middle [m], negative inside: |p_S| (1 -
  /// F^(-e1/2)), Gross and Boult, "Error of Fit Measures for Recovering Parametric Solids", 1988.
  double radial_distance(const Eigen::Vector3d& p_W) const;
};

/// The superquadric whose surface fits `points_W` [m] best: its 11 parameters by Levenberg and
/// Marquardt's method on sqrt(a1 a2 a3) (F^e1 - 1), whose first factor prefers the smallest of
/// those that fit as well (F. Solina, R. Bajcsy, "Recovery of Parametric Models from Range Images:
/// The Case for Superquadrics with Global Deformations", PAMI 1990, equation 13). It starts from an
/// ellipsoid in the box along the points' principal axes, with each of the three as its z axis; the
/// best of these fits counts. At most 1000 of the points are used, spread evenly.
/// @throws geometry::InputError for fewer points than parameters, for one that is not finite, and
/// when all are in one place.
Superquadric fit_superquadric(const std::vector<Eigen::Vector3d>& points_W);

/// The closed mesh of what of the solid is over `table_W` (normal towards it), by cells of 1/64 of
/// its longest side. @throws geometry::InputError when nothing is.
geometry::TriangleMesh mesh_of(const Superquadric& solid, const geometry::Plane& table_W);

}  // namespace prehend::eval
