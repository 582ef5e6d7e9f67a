#pragma once

#include <functional>
#include <string>
#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/motion/pick_motion.h"
#include "prehend/robot/platform.h"

// From ranked grasps of a hand to the motion of the arm that carries it.
namespace prehend::planning {

/// What stands round a platform, in the world frame.
struct PlatformScene {
  geometry::Plane table_W;                                // normal towards the objects
  std::vector<geometry::TriangleMesh> object_pieces_W;    // convex, of the object to pick
  std::vector<geometry::TriangleMesh> obstacle_pieces_W;  // convex, of everything else
};

/// A grasp of the platform's hand.
struct PlatformGrasp {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();  // tool of the preshape
  Eigen::Vector3d approach_W = -Eigen::Vector3d::UnitZ();                // unit
  double pregrasp_distance = 0.08;                                       // m, > 0
  std::string preshape;
  Eigen::VectorXd open;  // of the hand's motors, before it closes
};

struct PlatformPickOptions {
  PlatformPickOptions() {
    pick.lift_height = 0.15;
    pick.budget = 2;
  }
  motion::PickOptions pick;         // `acceleration` is filled from arm_acceleration
  double arm_acceleration = 5;      // rad/s^2, > 0, of each joint of the arm
  double margin = 0.005;            // m, >= 0, kept from obstacles
  double sphere_resolution = 0.04;  // m, > 0, of the robot's balls
  double cover_resolution = 0.015;  // m, > 0, of the held object's balls
  Eigen::Vector3d move_W = Eigen::Vector3d::Zero();  // m, where the object is put; 0: only lifted
};

struct PlatformPick {
  motion::PickMotion motion;
  int grasp = -1;  // of the list; -1: none is reached
};

/// Whether the arm of `platform` reaches a pose X_WH of the hand's root, its links and the world
/// aside: for grasp::HandPlannerOptions::reaches. May refuse what a redundant arm reaches with few
/// of its elbows' angles only. The answer does not refer to the platform.
std::function<bool(const geometry::RigidTransform& X_WH)> arm_reach(
    const robot::Platform& platform);

/// Plans the arm's motion for the best grasp that it can execute: preshape after preshape, in the
/// order of their first grasp (the open hand of each is another shape to keep from the world), by
/// motion::plan_pick(). The table is a slab under the objects that ends 0.2 m before the arm's own
/// base. Ledgers of all preshapes are added up.
/// @param start of the arm's joints.
/// @throws std::invalid_argument for options out of range or a start of another size;
/// geometry::InputError for an unknown preshape or pieces without volume.
PlatformPick plan_platform_pick(const robot::Platform& platform, const robot::Positions& start,
                                const std::vector<PlatformGrasp>& grasps,
                                const PlatformScene& scene,
                                const PlatformPickOptions& options = {});

}  // namespace prehend::planning
