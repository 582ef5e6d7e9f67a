#include "prehend/planning/platform_pick.h"

#include <algorithm>
#include <chrono>
#include <memory>
#include <stdexcept>
#include <utility>

#include <Eigen/Geometry>

#include "prehend/geometry/rotation_between.h"
#include "prehend/motion/robot_spheres.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;
using std::chrono::steady_clock;

constexpr double kTableReach = 0.6;      // m, of the slab from the object, at most
constexpr double kTableThickness = 0.2;  // m
constexpr double kBaseClearance = 0.2;   // m, round the arm's base, where it stands on the table
constexpr int kElbowAngles = 8;          // for what the arm reaches at all
constexpr const char* kObject = "object";

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

// What the arm must keep from, in its base's frame.
motion::CollisionWorld world_of(const PlatformScene& scene, const RigidTransform& X_BW,
                                const Eigen::Vector3d& p_WO) {
  motion::CollisionWorld world;
  const Eigen::Vector3d p_WB = X_BW.inverse().translation();
  const Eigen::Vector3d on_table = scene.table_W.project(p_WO);
  const double reach =
      std::clamp((scene.table_W.project(p_WB) - on_table).norm() / std::sqrt(2.0) - kBaseClearance,
                 0.05, kTableReach);
  RigidTransform X_WT = RigidTransform::Identity();
  X_WT.linear() =
      geometry::rotation_between(Eigen::Vector3d::UnitZ(), scene.table_W.normal).toRotationMatrix();
  X_WT.translation() = on_table - kTableThickness / 2 * scene.table_W.normal;
  world.add_box("table", X_BW * X_WT, {2 * reach, 2 * reach, kTableThickness});
  for (const auto& piece : moved(scene.object_pieces_W, X_BW)) world.add_convex(kObject, piece);
  for (const auto& piece : moved(scene.obstacle_pieces_W, X_BW)) {
    world.add_convex("another object", piece);
  }
  return world;
}

void add_rejections(const std::vector<motion::PickRejection>& more,
                    std::vector<motion::PickRejection>* all) {
  for (const auto& rejection : more) {
    const auto same = std::find_if(all->begin(), all->end(), [&](const auto& known) {
      return known.filter == rejection.filter;
    });
    if (same == all->end()) {
      all->push_back(rejection);
    } else {
      same->count += rejection.count;
    }
  }
}

std::vector<std::string> preshapes_of(const std::vector<PlatformGrasp>& grasps) {
  std::vector<std::string> names;
  for (const auto& grasp : grasps) {
    if (std::find(names.begin(), names.end(), grasp.preshape) == names.end()) {
      names.push_back(grasp.preshape);
    }
  }
  return names;
}

}  // namespace

std::function<bool(const RigidTransform&)> arm_reach(const robot::Platform& platform) {
  const auto arm = std::make_shared<const robot::InverseKinematics>(
      platform.arm_chain(), robot::InverseOptions{.elbow_angles = kElbowAngles});
  return [arm, X_BW = platform.X_WB.inverse(),
          X_HF = platform.X_FH.inverse()](const RigidTransform& X_WH) {
    return !arm->solve(X_BW * X_WH * X_HF).solutions.empty();
  };
}

PlatformPick plan_platform_pick(const robot::Platform& platform, const robot::Positions& start,
                                const std::vector<PlatformGrasp>& grasps,
                                const PlatformScene& scene, const PlatformPickOptions& options) {
  const text::Require require{"PlatformPickOptions."};
  require(options.arm_acceleration > 0, "arm_acceleration must be positive");
  require(options.margin >= 0, "margin must not be negative");
  require(options.move_W.allFinite(), "move_W must be finite");
  if (scene.object_pieces_W.empty()) {
    throw std::invalid_argument("PlatformScene.object_pieces_W must not be empty");
  }
  const RigidTransform X_BW = platform.X_WB.inverse();
  const Eigen::Vector3d p_WO = middle_of(scene.object_pieces_W);
  const motion::CollisionWorld world = world_of(scene, X_BW, p_WO);
  const robot::InverseKinematics inverse(platform.arm_chain());

  motion::PickTask task;
  task.start = start;
  task.up_B = X_BW.linear() * scene.table_W.normal;
  task.object.name = kObject;
  task.object.X_BO.translation() = X_BW * p_WO;
  task.object.cover_O = motion::cover_convex_pieces(
      moved(moved(scene.object_pieces_W, X_BW), task.object.X_BO.inverse()),
      options.cover_resolution);
  if (!options.move_W.isZero()) {
    task.X_BO_place = task.object.X_BO;
    task.X_BO_place->translation() += X_BW.linear() * options.move_W;
  }
  motion::PickOptions pick = options.pick;
  pick.acceleration = Eigen::VectorXd::Constant(inverse.chain().size(), options.arm_acceleration);

  PlatformPick result;
  result.motion.problem = "there are no grasps";
  std::vector<motion::PickRejection> rejections;
  std::vector<motion::PickStage> times;
  const auto begin = steady_clock::now();
  for (const std::string& name : preshapes_of(grasps)) {
    const robot::Preshape& preshape = platform.hand.preshape(name);
    std::vector<int> indices;
    task.grasps.clear();
    Eigen::VectorXd open = preshape.open;
    for (std::size_t i = 0; i < grasps.size(); ++i) {
      if (grasps[i].preshape != name) continue;
      if (indices.empty() && grasps[i].open.size() == open.size()) open = grasps[i].open;
      indices.push_back(static_cast<int>(i));
      task.grasps.push_back({platform.X_BF(grasps[i].X_WG, preshape),
                             X_BW.linear() * grasps[i].approach_W, grasps[i].pregrasp_distance});
    }
    if (options.pick.budget > 0) {
      const std::chrono::duration<double> spent = steady_clock::now() - begin;
      pick.budget = std::max(1e-3, options.pick.budget - spent.count());
    }
    const robot::RobotModel model = platform.with_hand_at(platform.hand.all_positions(open));
    const motion::RobotInWorld robot(
        inverse.chain(),
        motion::make_robot_spheres(model, platform.base, platform.flange,
                                   options.sphere_resolution),
        world, options.margin);
    result.motion = motion::plan_pick(robot, inverse, task, pick);
    add_rejections(result.motion.rejections, &rejections);
    times.insert(times.end(), result.motion.times.begin(), result.motion.times.end());
    if (result.motion.found()) {
      result.grasp = indices[static_cast<std::size_t>(result.motion.grasp)];
      break;
    }
  }
  result.motion.rejections = std::move(rejections);
  result.motion.times = std::move(times);
  return result;
}

}  // namespace prehend::planning
