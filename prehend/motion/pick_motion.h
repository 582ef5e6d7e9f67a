#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "prehend/motion/ball_cover.h"
#include "prehend/motion/blended_trajectory.h"
#include "prehend/motion/planner_registry.h"
#include "prehend/motion/rrt_connect.h"
#include "prehend/motion/segment.h"
#include "prehend/robot/inverse_kinematics.h"
#include "prehend/text/knob.h"

namespace prehend::motion {

/// A way to hold the object. Base frame B, tip T.
struct PickGrasp {
  geometry::RigidTransform X_BT;  // of the tip when the hand closes
  Eigen::Vector3d approach_direction_B = -Eigen::Vector3d::UnitZ();  // the hand's way to it; unit
  double pregrasp_distance = 0.1;                                    // m, of that way, > 0
  double expected_success = 1;  // 0..1, how likely it is thought to hold
  /// m, >= 0, that the hand has below it when it closes: at a place it goes no lower than that.
  double room_below = std::numeric_limits<double>::infinity();
};

/// What is grasped. Frame O.
struct PickObject {
  std::string name = "object";  // in the collision world; nothing of that name: not an obstacle
  geometry::RigidTransform X_BO = geometry::RigidTransform::Identity();
  BallCover cover_O;  // moves with the hand once it is grasped; empty: nothing does
};

struct PickTask {
  robot::Positions start;
  std::vector<PickGrasp> grasps;  // in any order
  PickObject object;
  /// Where the object may go, best first; empty: it is only lifted.
  std::vector<geometry::RigidTransform> X_BO_places;
  Eigen::Vector3d up_B = Eigen::Vector3d::UnitZ();  // away from the table; unit
  /// m: lifted so far from X_BO, the object is above all that stands about; negative: it is. It is
  /// carried so high where the arm reaches that, over the place, too. None: by
  /// PickOptions::lift_height, as far as the object's shape allows.
  std::optional<double> clear_height;
  /// The way down to the place goes on as far as the hand may (PickGrasp::room_below, where that is
  /// finite): for an object that may end higher than its shape, by an arm that feels when it
  /// stands.
  bool goes_on_down = false;
  /// Names in the collision world that the hand keeps clear of on the straight ways at the grasp
  /// and at the place, as its grasps were planned with them, exactly: there it is not tested again
  /// with what holds its links, which reaches beyond them.
  std::vector<std::string> kept_clear;
};

struct PickOptions {
  /// The trade between a grasp and its path, 0..1: so much less expected success is taken for the
  /// path that the search finds first. 0: the path decides between equal grasps only.
  double success_for_path = 0.05;
  /// m, > 0, before the carry and above the place; up to 0.3 m more where what is held would else
  /// touch what stands about it, or PickTask::clear_height asks for it.
  double lift_height = 0.1;
  double straight_step = 0.01;  // m, of the straight segments, > 0
  int goals = 24;               // positions above grasps that are looked for at most, >= 1
  int goals_per_grasp = 4;      // >= 1
  double budget = 0;            // s of wall time for all; 0: as long as it takes
  std::string planner = kDefaultPlanner;  // of reach and carry, see PlannerRegistry
  PathOptions path;                       // of reach and carry; its budget is not used
  Eigen::VectorXd acceleration;  // rad/s^2 or m/s^2 of each joint; empty: segments are not timed
  TimingOptions timing;
  double straight_speed_factor = 0.3;  // of straight segments, in (0, 1]
  /// m/s, >= 0, of the tool on straight segments, where things are touched; 0: as fast as the
  /// joints.
  double straight_speed = 0;
  /// m/s, >= 0, of the tool at most on the approach to what may stand elsewhere than it is thought
  /// to; 0: as on other straight segments. What is stopped by touch has gone on for as long as that
  /// takes, and presses by as much more the faster it came.
  double guarded_speed = 0;

  /// See text/knob.h.
  template <class Self, class Visit>
  static void knobs(Self& self, Visit&& visit) {
    using text::Knob;
    visit(Knob{"budget", self.budget, "s", 0, 3600,
               "for one motion of the arm; 0: as long as it takes"});
    visit(Knob{"lift_height", self.lift_height, "m", 0.005, 2,
               "straight up, before the carry and above the place; up to 0.3 m more where what is "
               "held would touch something else"});
    visit(
        Knob{"success_for_path", self.success_for_path, "", 0, 1,
             "so much less expected success of a grasp is taken for the path that is found first"});
    visit(Knob{"straight_speed", self.straight_speed, "m/s", 0, 5,
               "of the tool where things are touched; 0: as fast as the joints"});
    visit(Knob{"straight_speed_factor", self.straight_speed_factor, "", 0.01, 1,
               "of the joints' speed where things are touched"});
  }
};

/// What becomes of a grasp, in the order of the tests.
enum class PickFilter {
  kOutOfReach,
  kBeyondLimits,
  kGraspTouches,     // the arm, or the hand something else than the object, when it closes
  kApproach,         // not straight to the grasp
  kPregraspTouches,  // before the approach
  kLift,             // not straight up with the object
  kPlace,            // of the place: reach, limits, touch, or the straight ways down and back
  kPath,             // no path to it, or on from it, was found
  kNotTried,         // a better one, enough goals, or the budget's end, before it
};
const char* to_string(PickFilter filter);  // "out of reach"

struct PickRejection {
  PickFilter filter = PickFilter::kOutOfReach;
  int count = 0;  // grasps that got as far as this and no farther
  /// Of the one nearest to passing, in words.
  std::string nearest_miss;
};

struct PickSegment {
  SegmentKind kind = SegmentKind::kReach;
  std::vector<robot::Positions> waypoints;
  bool holds = false;                           // the object moves with the hand
  std::optional<BlendedTrajectory> trajectory;  // with PickOptions::acceleration
};

struct PickStage {
  std::string name;    // goals, reach, carry, timing
  double seconds = 0;  // wall time
};

struct PickMotion {
  std::vector<PickSegment> segments;  // in order; empty: none was found
  int grasp = -1;                     // the one that is reached
  int place = -1;                     // of PickTask::X_BO_places; -1: it is only lifted
  std::string problem;                // why there is none, in words
  std::vector<PickRejection> rejections;
  std::vector<PickStage> times;
  int goals = 0;  // positions above grasps that the search could end at
  /// Share of the time of the segment kPlace, in (0, 1], at which the object stands by its shape;
  /// the rest is PickTask::goes_on_down.
  double place_share = 1;

  bool found() const { return !segments.empty(); }
};

/// Indices of grasps by their expected success: the best and all within `width` of it, then the
/// best of the rest and all within `width` of that, ...; in each the best first, equal ones in
/// order.
std::vector<std::vector<std::size_t>> success_tiers(const std::vector<double>& expected_success,
                                                    double width);

/// A motion that picks an object and, if asked, places it: reach (`planner`, to the goal set of all
/// solutions of the best grasps from which the rest is possible), approach (straight), lift
/// (straight up, with the object), carry (`planner`, with the object), place (straight down, where
/// the place is lower than the hand has room the object ends that much higher),
/// retreat (straight back). The hand closes between approach and lift, and opens between place and
/// retreat.
///
/// Which grasp: the one with the best expected success, the path second. The grasps within
/// `success_for_path` of the best are one goal set, in which the search takes what it reaches
/// first; only when none of them can be executed, it goes on to those within as much of the best
/// that is left (success_tiers()). Which place: of the grasp that is taken, the first that can be
/// reached.
///
/// Who may touch what: the hand the object, on the straight segments next to grasp and place. What
/// is held keeps from each thing what it kept when it was grasped, down to 1 mm less, until it is
/// lifted: it stands on the table, and beside others. At the place it may be as deep in something
/// as its cover's overshoot. Everything else keeps the robot's margin. When an arm's other links
/// touch the object, that counts.
///
/// What touches is up to the checker of `robot` (RobotInWorld::use_checker()); how near what is
/// held is to things, always to its balls.
///
/// Reentrant. Same task, options and seed, same motion, as far as the planner is repeatable and
/// unless the budget ends a search; then the best so far is given: fewer goals, or no carry, which
/// is a failure that says so. A search among the best grasps may use half of what is left of the
/// budget while others remain.
/// @param robot with the object in its world and nothing attached.
/// @throws std::invalid_argument for a bad option, an unknown planner, a start of another size,
/// directions that are not unit vectors, an expected success outside [0, 1], or what is not finite.
PickMotion plan_pick(const RobotInWorld& robot, const robot::InverseKinematics& inverse,
                     const PickTask& task, const PickOptions& options = {});

}  // namespace prehend::motion
