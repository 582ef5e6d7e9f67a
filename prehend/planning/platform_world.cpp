#include "prehend/planning/platform_world.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "prehend/motion/robot_shapes.h"
#include "prehend/motion/robot_spheres.h"

namespace prehend::planning {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

constexpr double kLeastTable = 0.05;     // m
constexpr double kBaseOnTable = 0.3;     // m, height of a base over the table, that stands on it
constexpr double kTableThickness = 0.2;  // m
constexpr double kBaseClearance = 0.2;   // m, round the arm's base, where it stands on the table

}  // namespace

std::vector<TriangleMesh> moved(const std::vector<TriangleMesh>& meshes, const RigidTransform& X) {
  std::vector<TriangleMesh> result;
  for (const auto& mesh : meshes) result.push_back(geometry::transformed(mesh, X));
  return result;
}

Eigen::Vector3d middle_of(const std::vector<TriangleMesh>& meshes) {
  Eigen::AlignedBox3d box;
  for (const auto& mesh : meshes) box.extend(geometry::bounds(mesh));
  return box.center();
}

TableSlab::TableSlab(const robot::Platform& platform, const geometry::Plane& table,
                     const Eigen::Vector3d& p_WO) {
  const Eigen::Vector3d on_table = table.project(p_WO), base = platform.X_WB.translation();
  Eigen::Vector3d away = on_table - table.project(base);
  const double to_base = away.norm();
  if (std::abs(table.signed_distance(base)) < kBaseOnTable) {
    back = std::clamp(to_base - kBaseClearance, kLeastTable, reach);
  }
  if (to_base < kLeastTable) away = table.normal.unitOrthogonal();
  X_WT.linear().col(0) = (away - away.dot(table.normal) * table.normal).normalized();
  X_WT.linear().col(2) = table.normal;
  X_WT.linear().col(1) = table.normal.cross(Eigen::Vector3d(X_WT.linear().col(0)));
  X_WT.translation() = on_table;
}

double TableSlab::beyond(const Eigen::Vector3d& p_W) const {
  const Eigen::Vector3d p_T = X_WT.inverse(Eigen::Isometry) * p_W;
  return std::max({-back - p_T.x(), p_T.x() - reach, std::abs(p_T.y()) - reach});
}

motion::CollisionWorld world_of(const robot::Platform& platform, const PlatformScene& scene) {
  const RigidTransform X_BW = platform.X_WB.inverse();
  const TableSlab slab(platform, scene.table_W, middle_of(scene.object_pieces_W));
  motion::CollisionWorld world;
  RigidTransform X_WMiddle = slab.X_WT;
  X_WMiddle.translation() +=
      slab.X_WT.linear() * Eigen::Vector3d(0.5 * (slab.reach - slab.back), 0, -kTableThickness / 2);
  world.add_box(kTableName, X_BW * X_WMiddle,
                {slab.reach + slab.back, 2 * slab.reach, kTableThickness});
  for (const auto& piece : moved(scene.object_pieces_W, X_BW)) world.add_convex(kObjectName, piece);
  for (const auto& piece : moved(scene.obstacle_pieces_W, X_BW)) {
    world.add_convex("another object", piece);
  }
  return world;
}

motion::RobotInWorld robot_in(const motion::CollisionWorld& world, const robot::Platform& platform,
                              const Eigen::VectorXd& open, double margin, double sphere_resolution,
                              const std::shared_ptr<const motion::CollisionChecker>& checker) {
  const robot::RobotModel model = platform.with_hand_at(platform.hand.all_positions(open));
  motion::RobotInWorld robot(
      platform.arm_chain(),
      motion::make_robot_spheres(model, platform.base, platform.flange, sphere_resolution), world,
      margin);
  if (checker) {
    robot.use_checker(checker, motion::make_robot_shapes(model, platform.base, platform.flange));
  }
  return robot;
}

}  // namespace prehend::planning
