#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/point_cloud.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/robot/gripper_model.h"

namespace prehend::geometry {

class SurfaceQuery;

}  // namespace prehend::geometry

namespace prehend::grasp {

struct CollisionOptions {
  double table_margin = 0.004;     // m, >= 0, that every part of the hand keeps to the table
  double object_margin = 0.0015;   // m, >= 0, between the open hand and the object
  double obstacle_margin = 0.005;  // m, >= 0, between the hand and other objects

  void validate() const;  ///< @throws std::invalid_argument naming the field.
};

/// A box aligned with the gripper frame G.
struct HandBox {
  Eigen::Vector3d center_G;
  Eigen::Vector3d half_size;
};

/// Left finger, right finger and housing of the hand at `opening` [m], swept along the straight
/// approach that starts `approach_distance` [m] behind. As the approach is G's z axis, the swept
/// volume of a box is a longer box: the test along the whole line is exact.
std::vector<HandBox> swept_hand(const robot::GripperModel& gripper, double opening,
                                double approach_distance);

/// What else is there besides the object to be grasped.
struct Obstacles {
  std::vector<geometry::TriangleMesh> meshes_W;
  geometry::PointCloud cloud_W;  // invalid points are skipped
};

enum class HandCollision { kNone, kTable, kObject, kObstacle };

/// The world an open hand must not touch. A closed surface that would swallow a whole box is
/// noticed too. Meshes of obstacles are made ready when a box first comes near them, so that those
/// out of reach cost nothing.
class CollisionScene {
 public:
  /// @param object_W kept as a reference; null: there is none. Obstacles without triangles are
  ///     skipped
  /// @throws geometry::InputError for an obstacle with NaN or indices out of range.
  CollisionScene(const geometry::SurfaceQuery* object_W, const geometry::Plane& table,
                 const Obstacles& obstacles, const CollisionOptions& options = {});
  ~CollisionScene();
  CollisionScene(CollisionScene&&) noexcept;
  CollisionScene& operator=(CollisionScene&&) noexcept;

  /// Lowest height of the hand's boxes at X_WG over the table [m].
  double table_clearance(const std::vector<HandBox>& hand,
                         const geometry::RigidTransform& X_WG) const;

  /// Whether a box comes nearer to the object than the margin, whatever else is met.
  bool touches_object(const std::vector<HandBox>& hand, const geometry::RigidTransform& X_WG) const;

  /// The first thing met of table, object and obstacles, in this order.
  HandCollision check(const std::vector<HandBox>& hand, const geometry::RigidTransform& X_WG) const;

 private:
  struct Implementation;
  std::unique_ptr<Implementation> implementation_;
};

}  // namespace prehend::grasp
