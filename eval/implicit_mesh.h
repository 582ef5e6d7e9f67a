#pragma once

#include <functional>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::eval {

/// A solid as a function of the point [m]: negative inside, positive outside, about the distance
/// to the surface near it.
using Implicit = std::function<double(const Eigen::Vector3d&)>;

/// The zero surface of `solid` within `box` by marching tetrahedra on a grid of cubes of side
/// `cell` [m], each cut into six (Freudenthal): closed, manifold and facing outward whatever the
/// function. Edges sharper than the cell are bevelled. Cost: one evaluation a grid point.
/// @throws geometry::InputError when the solid reaches out of the box or has no inside there;
/// std::invalid_argument for a bad cell or a grid of more than 1e8 points.
geometry::TriangleMesh mesh_of(const Implicit& solid, const Eigen::AlignedBox3d& box, double cell);

/// Distances to elementary solids [m], to be combined by min (union) and max (intersection).
namespace solids {

/// Box of full side lengths `size` round `center` with edges of the given radius.
double rounded_box(const Eigen::Vector3d& p, const Eigen::Vector3d& center,
                   const Eigen::Vector3d& size, double radius);

/// Balls swept from a to b, radius growing linearly (a bound of the distance, exact on the axis).
double cone_segment(const Eigen::Vector3d& p, const Eigen::Vector3d& a, const Eigen::Vector3d& b,
                    double radius_a, double radius_b);

/// Ellipsoid with half axes `radii` (first-order distance).
double ellipsoid(const Eigen::Vector3d& p, const Eigen::Vector3d& center,
                 const Eigen::Vector3d& radii);

/// Ring about the axis `axis` (unit) with radii `major` of the circle and `minor` of the tube.
double torus(const Eigen::Vector3d& p, const Eigen::Vector3d& center, const Eigen::Vector3d& axis,
             double major, double minor);

/// Solid of revolution about z of the closed polygon `outline` in (radius, z).
double revolution(const Eigen::Vector3d& p, const std::vector<Eigen::Vector2d>& outline);

}  // namespace solids
}  // namespace prehend::eval
