#pragma once

#include <memory>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/motion/collision_checker.h"
#include "prehend/motion/collision_world.h"
#include "prehend/motion/robot_in_world.h"
#include "prehend/robot/platform.h"

// What an arm and its hand must keep from.
namespace prehend::planning {

/// What stands round a platform, in the world frame.
struct PlatformScene {
  geometry::Plane table_W;                                // normal towards the objects
  std::vector<geometry::TriangleMesh> object_pieces_W;    // convex, of the object to pick
  std::vector<geometry::TriangleMesh> obstacle_pieces_W;  // convex, of everything else
};

/// Names in world_of().
inline constexpr const char* kObjectName = "object";
inline constexpr const char* kTableName = "table";

/// Meshes moved by `X`.
std::vector<geometry::TriangleMesh> moved(const std::vector<geometry::TriangleMesh>& meshes,
                                          const geometry::RigidTransform& X);
/// The centre of the box round all of them.
Eigen::Vector3d middle_of(const std::vector<geometry::TriangleMesh>& meshes);

/// The slab of table that motions are planned on, in the world: a rectangle that ends 0.2 m before
/// the arm's base where that stands on the table. Origin of X_WT under the object, x away from the
/// base, z the normal.
struct TableSlab {
  geometry::RigidTransform X_WT = geometry::RigidTransform::Identity();  // of its surface
  double reach = 0.8;                                                    // m, from the object
  double back = 0.8;  // m, the same towards the base

  /// @param p_WO of the object.
  TableSlab(const robot::Platform& platform, const geometry::Plane& table,
            const Eigen::Vector3d& p_WO);

  /// How far a point is beyond the slab's edges [m]; not above 0 on it.
  double beyond(const Eigen::Vector3d& p_W) const;
};

/// What the arm must keep from, in its base's frame: the table's slab, object, obstacles.
motion::CollisionWorld world_of(const robot::Platform& platform, const PlatformScene& scene);

/// The platform's arm with its hand open so (motors), in a world of world_of().
/// @param margin m, >= 0, kept from all. @param sphere_resolution m, > 0, of the robot's balls.
/// @param checker what tells whether it touches something; null: its balls.
motion::RobotInWorld robot_in(const motion::CollisionWorld& world, const robot::Platform& platform,
                              const Eigen::VectorXd& open, double margin, double sphere_resolution,
                              const std::shared_ptr<const motion::CollisionChecker>& checker);

}  // namespace prehend::planning
