#pragma once

#include <memory>

#include <Eigen/Core>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::contact {

/// Short rays on a closed mesh, in packets of kPacket (Embree's bounding volume hierarchy). Embree
/// finds the triangle in single precision; the distance is that to the triangle's plane in double
/// precision. Const and safe in several threads. The hierarchy is built in the constructor.
class MeshRays {
 public:
  static constexpr int kPacket = 8;

  /// @throws geometry::InputError for a mesh without triangles, with indices out of range or NaN.
  explicit MeshRays(geometry::TriangleMesh mesh);
  ~MeshRays();

  const geometry::TriangleMesh& mesh() const;

  /// As Shape::ray_distance: a ray that first sees a triangle from its back begins inside.
  double first_hit(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                   double limit) const;

  /// kPacket rays at once; coordinates one array each. `active` false: not cast, result infinity.
  struct Packet {
    double ox[kPacket], oy[kPacket], oz[kPacket];
    double dx[kPacket], dy[kPacket], dz[kPacket];  // unit
    bool active[kPacket];
    double distance[kPacket];  // result [m]
    int triangle[kPacket];     // result: met first, or kNone; kEdgeOn: `distance` counts
  };
  static constexpr int kNone = -1;    // nothing within the limit
  static constexpr int kEdgeOn = -2;  // a triangle whose plane says nothing about the distance
  void first_hits(Packet& packet, double limit) const;

  /// Distance to the plane of a triangle that such a ray met, as first_hits() gives it.
  double plane_distance(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                        int triangle, double limit) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace prehend::contact
