#pragma once

#include <memory>
#include <optional>
#include <vector>

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::geometry {

struct RayHit {
  double distance = 0;  // along the unit direction [m]
  int triangle = 0;
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // unit, of the hit triangle
};

struct NearestPoint {
  Eigen::Vector3d point = Eigen::Vector3d::Zero();
  double distance = 0;  // unsigned [m]
  int triangle = 0;
};

/// Rays and nearest points of one surface. Queries may run in several threads at once. Pure
/// virtual, so that plug-ins need nothing of prehend linked to them.
class SurfaceQuery {
 public:
  virtual ~SurfaceQuery() = default;

  virtual const TriangleMesh& mesh() const = 0;

  /// First triangle hit from `origin` along `direction` (unit) within (0, max_distance] [m].
  virtual std::optional<RayHit> cast_ray(const Eigen::Vector3d& origin,
                                         const Eigen::Vector3d& direction,
                                         double max_distance = 1e9) const = 0;

  /// cast_ray() from each origin along one direction (unit), several at a time: three to five times
  /// as fast for rays side by side. `hits` is resized.
  virtual void cast_rays(const std::vector<Eigen::Vector3d>& origins,
                         const Eigen::Vector3d& direction, double max_distance,
                         std::vector<std::optional<RayHit>>* hits) const = 0;

  /// Axis-aligned box round all vertices.
  virtual const Eigen::AlignedBox3d& box() const = 0;

  /// The point of the surface nearest to `point`, if within `max_distance` [m].
  virtual std::optional<NearestPoint> nearest(const Eigen::Vector3d& point,
                                              double max_distance = 1e9) const = 0;

  /// Indices of all triangles within `distance` [m] of `point`, and of some little beyond it, in no
  /// order that means anything but the same each time. `triangles` is emptied first.
  virtual void near_triangles(const Eigen::Vector3d& point, double distance,
                              std::vector<int>* triangles) const = 0;

  /// True when `point` is inside the (watertight) mesh: on most of three rays the first surface
  /// met is seen from its back.
  virtual bool contains(const Eigen::Vector3d& point) const = 0;

  /// Distance to the surface, negative inside [m].
  virtual double signed_distance(const Eigen::Vector3d& point) const = 0;
};

/// Queries on a mesh by Embree's bounding volume hierarchy. Building costs O(t log t); the mesh is
/// copied. Embree works in single precision: expect 1e-6 relative to the mesh's size and distance
/// from the origin, so keep meshes in a frame near them.
class MeshQuery final : public SurfaceQuery {
 public:
  /// @throws InputError for a mesh without triangles, with indices out of range or with NaN.
  explicit MeshQuery(TriangleMesh mesh);
  ~MeshQuery() override;
  MeshQuery(MeshQuery&&) noexcept;
  MeshQuery& operator=(MeshQuery&&) noexcept;

  const TriangleMesh& mesh() const override;
  std::optional<RayHit> cast_ray(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction,
                                 double max_distance = 1e9) const override;
  void cast_rays(const std::vector<Eigen::Vector3d>& origins, const Eigen::Vector3d& direction,
                 double max_distance, std::vector<std::optional<RayHit>>* hits) const override;
  const Eigen::AlignedBox3d& box() const override;
  std::optional<NearestPoint> nearest(const Eigen::Vector3d& point,
                                      double max_distance = 1e9) const override;
  void near_triangles(const Eigen::Vector3d& point, double distance,
                      std::vector<int>* triangles) const override;
  bool contains(const Eigen::Vector3d& point) const override;
  double signed_distance(const Eigen::Vector3d& point) const override;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace prehend::geometry
