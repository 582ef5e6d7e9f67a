#pragma once

#include <memory>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::contact {

class MeshRays;

/// The solid that pads feel, in body frame B. Rays meet primitives exactly (double precision); a
/// mesh's first triangle is found by Embree and its plane met in double precision.
class Shape {
 public:
  enum class Kind { kBox, kSphere, kCylinder, kCapsule, kHalfSpace, kMesh };

  // Each is centred at B's origin; lengths in metres. @throws std::invalid_argument naming the
  // length that is not finite and positive.
  static Shape box(const Eigen::Vector3d& size);        // full side lengths
  static Shape sphere(double radius);                   //
  static Shape cylinder(double radius, double length);  // along z, flat ends
  static Shape capsule(double radius, double length);   // along z, `length` between ball centres
  static Shape half_space();                            // z <= 0
  /// A closed mesh. @throws geometry::InputError for a mesh without triangles, with indices out of
  /// range or NaN.
  static Shape mesh(geometry::TriangleMesh mesh_B);

  Kind kind() const { return kind_; }
  const Eigen::Vector3d& half_size() const { return half_; }  // m, of a box
  double radius() const { return radius_; }                   // m
  double half_length() const { return half_.z(); }            // m, of cylinder and capsule
  const MeshRays& mesh_rays() const { return *mesh_; }        // of kMesh
  /// Bounds in B [m]; those of the half-space are empty, since it has none.
  const Eigen::AlignedBox3d& bounds() const { return bounds_; }

  /// Distance [m] along the unit `direction` from `origin` to where the ray enters the solid: 0
  /// when it begins inside, infinity when it meets nothing within `limit`.
  double ray_distance(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                      double limit) const;

  /// How deep `p` lies inside [m] and the outward unit normal of the surface's nearest point;
  /// negative outside, where the normal means nothing. Edges belong to one of their faces.
  /// @throws std::logic_error for a mesh, which answers such questions by geometry::MeshQuery.
  double depth_inside(const Eigen::Vector3d& p, Eigen::Vector3d& normal) const;

 private:
  Kind kind_ = Kind::kBox;
  Eigen::Vector3d half_ = Eigen::Vector3d::Zero();
  double radius_ = 0;
  std::shared_ptr<const MeshRays> mesh_;
  Eigen::AlignedBox3d bounds_;
};

}  // namespace prehend::contact
