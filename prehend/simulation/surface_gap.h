#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::simulation {

/// A solid's surface and points of it some millimetres apart.
class SampledSurface {
 public:
  /// @throws geometry::InputError as MeshQuery
  explicit SampledSurface(const geometry::TriangleMesh& mesh_B);

  const geometry::MeshQuery& query() const { return query_; }
  const std::vector<Eigen::Vector3d>& points() const { return points_; }  // m, in B
  double lowest(const geometry::RigidTransform& X_WB) const;   // m, z of its lowest point
  double highest(const geometry::RigidTransform& X_WB) const;  // m

 private:
  geometry::MeshQuery query_;
  std::vector<Eigen::Vector3d> points_;
};

struct SurfaceGap {
  double distance = 0;                                  // m
  Eigen::Vector3d p_W = Eigen::Vector3d::Zero();        // where they are nearest, on the second
  Eigen::Vector3d normal_W = Eigen::Vector3d::UnitZ();  // unit, out of the second
};

/// How far two surfaces are apart, `most` [m] when it is more, by the points of each and the
/// triangles of the other: 4 mm too far at most, where two edges cross in mid-air; where faces,
/// or a corner and a face are nearest it is exact. How deep one is in the other it does not tell,
/// see surfaces_overlap().
SurfaceGap surface_gap(const SampledSurface& a, const geometry::RigidTransform& X_WA,
                       const SampledSurface& b, const geometry::RigidTransform& X_WB, double most);

/// Whether a point of one is inside the other.
bool surfaces_overlap(const SampledSurface& a, const geometry::RigidTransform& X_WA,
                      const SampledSurface& b, const geometry::RigidTransform& X_WB);

}  // namespace prehend::simulation
