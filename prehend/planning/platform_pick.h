#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "prehend/geometry/plane.h"
#include "prehend/geometry/triangle_mesh.h"
#include "prehend/grasp/planner.h"
#include "prehend/motion/checker_registry.h"
#include "prehend/motion/pick_motion.h"
#include "prehend/planning/free_places.h"
#include "prehend/planning/held_views.h"
#include "prehend/planning/platform_world.h"
#include "prehend/robot/platform.h"

// From ranked grasps of a hand to the motion of the arm that carries it.
namespace prehend::planning {

/// A grasp of the platform's hand.
struct PlatformGrasp {
  geometry::RigidTransform X_WG = geometry::RigidTransform::Identity();  // tool of the preshape
  Eigen::Vector3d approach_W = -Eigen::Vector3d::UnitZ();                // unit
  double pregrasp_distance = 0.08;                                       // m, > 0
  std::string preshape;
  Eigen::VectorXd open;         // of the hand's motors, before it closes; empty: the preshape's
  Eigen::VectorXd closed_all;   // of all its joints when it holds; empty: not known
  double expected_success = 1;  // 0..1, as motion::PickGrasp
  /// The hand's straight ways were planned with the table, by the hand's own shapes.
  bool clears_table = false;
};

struct PlatformPickOptions {
  PlatformPickOptions() {
    pick.lift_height = 0.15;
    pick.straight_speed = 0.12;
    pick.budget = 2;
  }
  motion::PickOptions pick;  // `acceleration` is filled from the platform's
  /// What tells whether the robot touches something, see motion::CheckerRegistry.
  std::string checker = motion::kDefaultChecker;
  double margin = 0.005;            // m, >= 0, kept from obstacles
  double sphere_resolution = 0.04;  // m, > 0, of the robot's balls
  double cover_resolution = 0.015;  // m, > 0, of the held object's balls
  /// m, displacements by which the object may be put elsewhere, best first (free_places()); empty:
  /// it is only lifted.
  std::vector<Eigen::Vector3d> moves_W;
  /// Nothing is certain of the object's shape. Where it is carried elsewhere, it is lifted above
  /// all that stands about, if the arm reaches so high, and its way down goes on as far as the hand
  /// may; the approach is slow. For an arm that feels what it meets (guarded moves: Will and
  /// Grossman, IEEE Transactions on Computers C-24, 1975).
  bool guarded = false;
  double shift = 0.02;  // m, >= 0, of PlatformPick::shifts at most; 0: none are looked for
  std::optional<HeldInspection> inspection;  // none: PlatformPick::views are not looked for

  /// With those of `pick`. See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    motion::PickOptions::knobs(self.pick, visit);
    visit(Knob{"margin", self.margin, "m", 0, 0.2, "that the arm keeps from obstacles"});
  }
};

/// A straight way of the open hand to a side, from where it closes on the object.
struct SidewaysShift {
  Eigen::Vector3d way_W = Eigen::Vector3d::Zero();  // m
  Eigen::VectorXd offsets;                          // rad or m, of the arm's joints at its end
};

struct PlatformPick {
  motion::PickMotion motion;  // its `place` is of PlatformPickOptions::moves_W
  int grasp = -1;             // of the list; -1: none is reached
  /// To both sides along the closing direction and across it, as far as it is free of all but the
  /// object, of PlatformPickOptions::shift; those that are not free at all are left out.
  std::vector<SidewaysShift> shifts;
  HeldViews views;  // of PlatformPickOptions::inspection, from the end of the lift on
};

/// Whether the arm of `platform` reaches a pose X_WH of the hand's root, its links and the world
/// aside: for grasp::PlannerOptions::reaches. May refuse what a redundant arm reaches with few
/// of its elbows' angles only. The answer does not refer to the platform.
std::function<bool(const geometry::RigidTransform& X_WH)> arm_reach(
    const robot::Platform& platform);

/// The same, with the arm's own links (not the hand, nor the link that carries it) clear of the
/// table of `scene`, as plan_platform_pick() by these options tests them. Else a planner keeps
/// grasps of low things from the side that look alike and that no arm comes to. Everything else in
/// the scene is left out: what closes on it, and paths, look at that.
std::function<bool(const geometry::RigidTransform& X_WH)> arm_reach_over_table(
    const robot::Platform& platform, const PlatformScene& scene,
    const PlatformPickOptions& options);

/// With the direction of approach of a platform that can take no other
/// (Platform::fixed_approach()), where none is given.
grasp::Reachability within_reach(grasp::Reachability reachability, const robot::Platform& platform);
/// The options with an arm that must reach each grasp and its pregrasp (arm_reach()).
grasp::PlannerOptions within_reach(grasp::PlannerOptions options, const robot::Platform& platform);

/// The grasp as the arm's motion needs it.
PlatformGrasp to_pick(const grasp::Grasp& grasp);

/// Free places for the object of `scene` (free_places()) on the part of the table that the arm's
/// motions are planned on. @throws as free_places().
FreePlaces free_places_for(const robot::Platform& platform, const PlatformScene& scene,
                           PlaceOptions options = {});

/// Plans the arm's motion for the best grasp that it can execute, by motion::plan_pick(): expected
/// success first, among grasps within `pick.success_for_path` the path. Grasps of one preshape and
/// opening are planned together, as the open hand of each is another shape to keep from the world;
/// of several, the one of the best grasp first. The table is a slab under the objects that ends
/// 0.2 m before the arm's own base. Ledgers of all are added up.
/// @param start of the arm's joints.
/// @throws std::invalid_argument for options out of range, an unknown planner or checker, or a
/// start of another size; geometry::InputError for an unknown preshape or pieces without volume.
PlatformPick plan_platform_pick(const robot::Platform& platform, const robot::Positions& start,
                                const std::vector<PlatformGrasp>& grasps,
                                const PlatformScene& scene,
                                const PlatformPickOptions& options = {});

}  // namespace prehend::planning
