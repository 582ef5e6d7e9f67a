#include "prehend/planning/platform_pick.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <memory>
#include <optional>
#include <stdexcept>
#include <utility>

#include <fmt/format.h>
#include <Eigen/Geometry>

#include "prehend/geometry/rotation_between.h"
#include "prehend/motion/pick_ledger.h"
#include "prehend/motion/pick_scenes.h"
#include "prehend/motion/planner_registry.h"
#include "prehend/robot/link_mesh.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;
using std::chrono::steady_clock;

constexpr int kElbowAngles = 8;         // for what the arm reaches at all
constexpr double kShareOfTime = 0.5;    // of what is left, while other grasps remain
constexpr double kShiftStep = 0.005;    // m, of straight ways to the sides
constexpr double kGuardedSpeed = 0.03;  // m/s
constexpr double kOverAll = 0.05;       // m, between what is carried over all and the highest of it
constexpr double kLower = 1e-6;         // m, of a place: less is none
constexpr double kOverTable = 0.008;    // m, of the hand at the end of a way down

/// Grasps of one preshape and opening, and the robot with its hand so.
struct HandShape {
  std::string preshape;
  Eigen::VectorXd open;
  motion::RobotInWorld robot;
};

}  // namespace

std::function<bool(const RigidTransform&)> arm_reach(const robot::Platform& platform) {
  const auto arm = std::make_shared<const robot::InverseKinematics>(
      platform.arm_chain(), robot::InverseOptions{.elbow_angles = kElbowAngles});
  return [arm, X_BW = platform.X_WB.inverse(),
          X_HF = platform.X_FH.inverse()](const RigidTransform& X_WH) {
    return !arm->solve(X_BW * X_WH * X_HF).solutions.empty();
  };
}

std::function<bool(const RigidTransform&)> arm_reach_over_table(
    const robot::Platform& platform, const PlatformScene& scene,
    const PlatformPickOptions& options) {
  struct Arm {
    robot::InverseKinematics inverse;
    motion::RobotSpheres balls;
    motion::CollisionWorld table;
    double margin;

    bool is_clear(const robot::Positions& q) const {
      thread_local std::vector<Eigen::Vector3d> centers;
      balls.centers(inverse.chain(), q, centers);
      for (std::size_t i = 0; i < centers.size(); ++i) {
        if (table.touches(centers[i], balls.spheres[i].radius, margin)) return false;
      }
      return true;
    }
  };
  robot::RobotModel model = platform.model;
  for (robot::Link& link : model.links) {
    if (link.name.starts_with("hand_")) link.shapes.clear();  // it is not looked at
  }
  const auto arm = std::make_shared<Arm>(Arm{
      robot::InverseKinematics(platform.arm_chain(),
                               robot::InverseOptions{.elbow_angles = kElbowAngles}),
      motion::make_robot_spheres(model, platform.base, platform.flange, options.sphere_resolution),
      world_of(platform, scene), options.margin});
  const int joints = arm->inverse.chain().size();
  std::erase_if(arm->balls.spheres, [joints](const motion::RobotSphere& ball) {
    return ball.joint < 0 || motion::part_of_ball(ball, false, joints) != motion::Part::kArm;
  });
  for (const std::string& name : arm->table.names()) {
    if (name != kTableName) arm->table.remove(name);
  }
  return [shared = std::shared_ptr<const Arm>(arm), X_BW = platform.X_WB.inverse(),
          X_HF = platform.X_FH.inverse()](const RigidTransform& X_WH) {
    const auto solutions = shared->inverse.solve(X_BW * X_WH * X_HF).solutions;
    return std::ranges::any_of(solutions, [&](const auto& q) { return shared->is_clear(q); });
  };
}

grasp::Reachability within_reach(grasp::Reachability reachability,
                                 const robot::Platform& platform) {
  if (!reachability.approach_W) {
    reachability.approach_W = platform.fixed_approach(platform.hand.preshapes.front());
  }
  return reachability;
}

grasp::PlannerOptions within_reach(grasp::PlannerOptions options, const robot::Platform& platform) {
  options.reaches = arm_reach(platform);
  return options;
}

PlatformGrasp to_pick(const grasp::Grasp& grasp) {
  return {grasp.X_WG, grasp.approach_W, grasp.pregrasp_distance,           grasp.preshape,
          grasp.open, grasp.closed_all, std::clamp(grasp.score, 0.0, 1.0), true};
}

FreePlaces free_places_for(const robot::Platform& platform, const PlatformScene& scene,
                           PlaceOptions options) {
  std::vector<Eigen::Vector3d> object;
  for (const auto& piece : scene.object_pieces_W) {
    object.insert(object.end(), piece.vertices.begin(), piece.vertices.end());
  }
  std::vector<std::vector<Eigen::Vector3d>> others;
  for (const auto& piece : scene.obstacle_pieces_W) others.push_back(piece.vertices);
  const TableSlab slab(platform, scene.table_W, middle_of(scene.object_pieces_W));
  options.unreachable = [&slab, &object](const Eigen::Vector3d& move_W) -> std::string {
    double beyond = 0;
    for (const Eigen::Vector3d& p : object) beyond = std::max(beyond, slab.beyond(p + move_W));
    if (beyond <= 0) return {};
    return fmt::format(
        "the table that motions are planned on ends {:.2f} m from the object towards the arm and "
        "{:.2f} m elsewhere, {:.2f} m before it",
        slab.back, slab.reach, beyond);
  };
  return free_places(scene.table_W, object, others, options);
}

namespace {

/// Plans for the grasps of a list, those of one hand's shape at a time.
class PlatformPicker {
 public:
  PlatformPicker(const robot::Platform& platform, const robot::Positions& start,
                 const std::vector<PlatformGrasp>& grasps, const PlatformScene& scene,
                 const PlatformPickOptions& options)
      : platform_(platform),
        grasps_(grasps),
        options_(options),
        table_W_(scene.table_W),
        X_BW_(platform.X_WB.inverse()),
        inverse_(platform.arm_chain()),
        checker_(motion::CheckerRegistry().create(options.checker)) {
    const Eigen::Vector3d p_WO = middle_of(scene.object_pieces_W);
    world_ = world_of(platform, scene);
    task_.start = start;
    task_.up_B = X_BW_.linear() * scene.table_W.normal;
    task_.object.name = kObjectName;
    task_.object.X_BO.translation() = X_BW_ * p_WO;
    task_.object.cover_O = motion::cover_convex_pieces(
        moved(moved(scene.object_pieces_W, X_BW_), task_.object.X_BO.inverse()),
        options.cover_resolution);
    for (const Eigen::Vector3d& move_W : options.moves_W) {
      RigidTransform X_BO = task_.object.X_BO;
      X_BO.translation() += X_BW_.linear() * move_W;
      task_.X_BO_places.push_back(X_BO);
    }
    if (options.guarded) task_.clear_height = height_over_all(scene);
    task_.goes_on_down = options.guarded;
    pick_ = options.pick;
    if (options.guarded) pick_.guarded_speed = kGuardedSpeed;
    pick_.acceleration = platform.acceleration;
  }

  PlatformPick plan() {
    std::vector<double> expected;
    for (const PlatformGrasp& grasp : grasps_) {
      shapes_of_.push_back(shape_of(grasp));
      expected.push_back(grasp.expected_success);
    }
    // In the order in which they are tried.
    std::vector<std::vector<std::size_t>> turns;
    for (const auto& tier : motion::success_tiers(expected, pick_.success_for_path)) {
      const std::size_t first = turns.size();
      for (const std::size_t i : tier) {
        const auto same = std::find_if(
            turns.begin() + static_cast<std::ptrdiff_t>(first), turns.end(),
            [&](const auto& turn) { return shapes_of_[turn.front()] == shapes_of_[i]; });
        if (same == turns.end()) {
          turns.push_back({i});
        } else {
          same->push_back(i);
        }
      }
    }
    for (std::size_t t = 0; t < turns.size(); ++t) {
      if (t > 0 && result_.grasp >= 0) {
        not_tried(turns[t].size(), "one as good or better can be executed");
      } else if (t > 0 && is_over()) {
        not_tried(turns[t].size(), "the budget was used up");
      } else {
        take_turn(turns[t], t + 1 == turns.size());
      }
    }
    if (result_.grasp < 0) result_.motion.problem = problem();
    result_.motion.rejections = std::move(rejections_);
    result_.motion.times = std::move(times_);
    return std::move(result_);
  }

 private:
  double left() const {
    return options_.pick.budget -
           std::chrono::duration<double>(steady_clock::now() - begin_).count();
  }
  bool is_over() const { return options_.pick.budget > 0 && left() <= 0; }

  std::size_t shape_of(const PlatformGrasp& grasp) {
    const robot::Preshape& preshape = platform_.hand.preshape(grasp.preshape);
    const Eigen::VectorXd& open =
        grasp.open.size() == preshape.open.size() ? grasp.open : preshape.open;
    for (std::size_t k = 0; k < shapes_.size(); ++k) {
      if (shapes_[k].preshape == grasp.preshape && shapes_[k].open == open) return k;
    }
    shapes_.push_back(
        {grasp.preshape, open,
         robot_in(world_, platform_, open, options_.margin, options_.sphere_resolution, checker_)});
    return shapes_.size() - 1;
  }

  /// m, by which the object is lifted to be above all obstacles; none: there are none.
  static std::optional<double> height_over_all(const PlatformScene& scene) {
    const Eigen::Vector3d& up_W = scene.table_W.normal;
    const double infinity = std::numeric_limits<double>::infinity();
    double lowest = infinity, highest = -infinity;
    for (const TriangleMesh& piece : scene.object_pieces_W) {
      for (const Eigen::Vector3d& p : piece.vertices) lowest = std::min(lowest, up_W.dot(p));
    }
    for (const TriangleMesh& piece : scene.obstacle_pieces_W) {
      for (const Eigen::Vector3d& p : piece.vertices) highest = std::max(highest, up_W.dot(p));
    }
    if (scene.obstacle_pieces_W.empty()) return std::nullopt;
    return highest + kOverAll - lowest;
  }

  void take_turn(const std::vector<std::size_t>& turn, bool is_last) {
    const HandShape& shape = shapes_[shapes_of_[turn.front()]];
    const robot::Preshape& preshape = platform_.hand.preshape(shape.preshape);
    const double infinity = std::numeric_limits<double>::infinity();
    task_.grasps.clear();
    task_.kept_clear = {kTableName};
    for (const std::size_t i : turn) {
      const PlatformGrasp& grasp = grasps_[i];
      if (!grasp.clears_table) task_.kept_clear.clear();
      task_.grasps.push_back({platform_.X_BF(grasp.X_WG, preshape),
                              X_BW_.linear() * grasp.approach_W, grasp.pregrasp_distance,
                              grasp.expected_success,
                              goes_lower() ? room_below(grasp, shape) : infinity});
    }
    if (options_.pick.budget > 0) {
      pick_.budget = std::max(1e-3, (is_last ? 1 : kShareOfTime) * left());
    }
    result_.motion = motion::plan_pick(shape.robot, inverse_, task_, pick_);
    motion::add_rejections(result_.motion.rejections, &rejections_);
    times_.insert(times_.end(), result_.motion.times.begin(), result_.motion.times.end());
    if (result_.motion.found()) {
      result_.grasp = static_cast<int>(turn[static_cast<std::size_t>(result_.motion.grasp)]);
      add_shifts(shape, grasps_[static_cast<std::size_t>(result_.grasp)].X_WG);
      if (options_.inspection) add_views(shape);
    } else if (result_.motion.rejections.empty()) {
      start_problem_ = result_.motion.problem;
      not_tried(turn.size(), start_problem_);
    }
  }

  // From the end of the approach. Where the object is, is what the shift is to mend.
  void add_shifts(const HandShape& shape, const RigidTransform& X_WG) {
    const auto approach =
        std::find_if(result_.motion.segments.begin(), result_.motion.segments.end(),
                     [](const motion::PickSegment& segment) {
                       return segment.kind == motion::SegmentKind::kApproach;
                     });
    if (options_.shift <= 0 || approach == result_.motion.segments.end()) return;
    const robot::Positions start = approach->waypoints.back();
    motion::RobotInWorld without = shape.robot;
    without.change_world([this](motion::CollisionWorld& world) {
      world.remove(kObjectName);
      for (const std::string& name : task_.kept_clear) {
        world.set_margin(name, motion::Part::kHand, -motion::CollisionWorld::kInfinity);
      }
    });
    const RigidTransform X_BT = without.chain().forward(start);
    for (const Eigen::Vector3d side_G : {Eigen::Vector3d::UnitY(), Eigen::Vector3d::UnitX()}) {
      for (const double length : {options_.shift, -options_.shift}) {
        for (const double share : {1.0, 0.5, 0.25}) {
          const Eigen::Vector3d way_W = share * length * X_WG.linear() * side_G;
          if ((X_BW_.linear() * way_W).dot(task_.up_B) < -kShiftStep) break;  // not to the table
          RigidTransform X_BT_there = X_BT;
          X_BT_there.translation() += X_BW_.linear() * way_W;
          const motion::JointPath path =
              motion::straight_path(without, start, X_BT_there, kShiftStep);
          if (path.waypoints.empty()) continue;
          result_.shifts.push_back({way_W, path.waypoints.back() - start});
          break;
        }
      }
    }
  }

  void add_views(const HandShape& shape) {
    const auto lift = std::find_if(result_.motion.segments.begin(), result_.motion.segments.end(),
                                   [](const motion::PickSegment& segment) {
                                     return segment.kind == motion::SegmentKind::kLift;
                                   });
    const HeldInspection& inspection = *options_.inspection;
    if (lift == result_.motion.segments.end()) return;
    // The tip is the flange.
    const PlatformGrasp& grasp = grasps_[static_cast<std::size_t>(result_.grasp)];
    const motion::PickGrasp& picked = task_.grasps[static_cast<std::size_t>(result_.motion.grasp)];
    const RigidTransform X_TW = (platform_.X_WB * picked.X_BT).inverse(Eigen::Isometry);
    HeldThing thing;
    for (SurfacePatch patch : inspection.patches_W) {
      patch.p_W = X_TW * patch.p_W;
      patch.normal_W = X_TW.linear() * patch.normal_W;
      thing.patches_T.push_back(patch);
    }
    const geometry::MeshQuery object_T(geometry::transformed(inspection.object_mesh_W, X_TW));
    thing.object_T = &object_T;
    std::optional<geometry::MeshQuery> hand_T;
    if (TriangleMesh hand = hand_mesh(grasp.closed_all); !hand.triangles.empty()) {
      hand_T.emplace(geometry::transformed(hand, platform_.X_FH));
      thing.hand_T = &*hand_T;
    }
    const motion::RobotInWorld carrying = motion::PickScenes(shape.robot, task_).carry(picked);
    const auto planner = motion::PlannerRegistry().create(pick_.planner);
    result_.views = plan_held_views(carrying, inverse_, platform_.X_WB, lift->waypoints.back(),
                                    thing, inspection.camera, table_W_, *planner, pick_.path,
                                    pick_.acceleration, inspection.options);
  }

  /// Whether the hand may be lower at a place than where it closes.
  bool goes_lower() const {
    return std::any_of(options_.moves_W.begin(), options_.moves_W.end(),
                       [this](const Eigen::Vector3d& move_W) {
                         return options_.guarded || move_W.dot(table_W_.normal) < -kLower;
                       });
  }

  /// m, from the lowest point of the hand, closed or open, to just above the table; 0 where it is
  /// not known how it closes.
  double room_below(const PlatformGrasp& grasp, const HandShape& shape) const {
    const robot::Preshape& preshape = platform_.hand.preshape(grasp.preshape);
    const RigidTransform X_WH =
        grasp.X_WG * (platform_.hand.X_HP * preshape.X_PG).inverse(Eigen::Isometry);
    const TriangleMesh closed = hand_mesh(grasp.closed_all);
    if (closed.vertices.empty()) return 0;
    double lowest = std::numeric_limits<double>::infinity();
    for (const TriangleMesh& mesh : {closed, hand_mesh(platform_.hand.all_positions(shape.open))}) {
      for (const Eigen::Vector3d& p_H : mesh.vertices) {
        lowest = std::min(lowest, table_W_.signed_distance(X_WH * p_H));
      }
    }
    return std::max(0.0, lowest - kOverTable);
  }

  /// Of the hand with its joints so, in its root's frame; empty where they are not known.
  TriangleMesh hand_mesh(const Eigen::VectorXd& all) const {
    std::vector<TriangleMesh> links;
    const auto joints = static_cast<Eigen::Index>(platform_.hand.model.joints.size());
    if (all.size() != joints) return {};
    std::vector<RigidTransform> poses;
    platform_.hand.link_poses(all, poses);
    for (std::size_t l = 0; l < poses.size(); ++l) {
      links.push_back(
          geometry::transformed(robot::link_mesh(platform_.hand.model.links[l]), poses[l]));
    }
    return geometry::concatenated(links);
  }

  void not_tried(std::size_t count, const std::string& why) {
    motion::add_rejections({{motion::PickFilter::kNotTried, static_cast<int>(count), why}},
                           &rejections_);
  }

  std::string problem() const {
    if (grasps_.empty()) return "there are no grasps";
    // The same for all of them.
    if (rejections_.size() == 1 && rejections_.front().nearest_miss == start_problem_) {
      return start_problem_;
    }
    return motion::rejection_problem(grasps_.size(), rejections_);
  }

  const robot::Platform& platform_;
  const std::vector<PlatformGrasp>& grasps_;
  const PlatformPickOptions& options_;
  geometry::Plane table_W_;
  RigidTransform X_BW_;
  robot::InverseKinematics inverse_;
  std::shared_ptr<const motion::CollisionChecker> checker_;  // null: balls
  motion::CollisionWorld world_;
  motion::PickTask task_;
  motion::PickOptions pick_;
  steady_clock::time_point begin_ = steady_clock::now();
  std::vector<HandShape> shapes_;
  std::vector<std::size_t> shapes_of_;  // of each grasp
  std::string start_problem_;
  std::vector<motion::PickRejection> rejections_;
  std::vector<motion::PickStage> times_;
  PlatformPick result_;
};

}  // namespace

PlatformPick plan_platform_pick(const robot::Platform& platform, const robot::Positions& start,
                                const std::vector<PlatformGrasp>& grasps,
                                const PlatformScene& scene, const PlatformPickOptions& options) {
  const text::Require require{"PlatformPickOptions."};
  PlatformPickOptions::knobs(options, text::CheckKnobs{require.of});
  for (const Eigen::Vector3d& move_W : options.moves_W) {
    require(move_W.allFinite(), "moves_W must be finite");
  }
  if (scene.object_pieces_W.empty()) {
    throw std::invalid_argument("PlatformScene.object_pieces_W must not be empty");
  }
  return PlatformPicker(platform, start, grasps, scene, options).plan();
}

}  // namespace prehend::planning
