#include "prehend/motion/pick_motion.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>
#include <utility>

#include "prehend/motion/pick_ledger.h"
#include "prehend/motion/pick_scenes.h"
#include "prehend/motion/pick_ways.h"
#include "prehend/motion/plan_path.h"

namespace prehend::motion {
namespace {

using geometry::RigidTransform;
using robot::InverseAnswer;
using robot::Positions;
using Clock = std::chrono::steady_clock;

constexpr double kShareForGoals = 0.5;  // of a tier's time, when there is a goal already
constexpr double kShareOfTier = 0.5;    // of what is left of the budget, when others remain
const PickMiss kNoTimeLeft{PickFilter::kNotTried, 0, "the budget was used up"};

/// From pregrasp to lifted, for one solution of one grasp.
struct Goal {
  std::size_t grasp = 0;
  std::vector<Positions> approach, lift;
};

/// The first place of a grasp that it can be put down at, and how.
struct Place {
  std::size_t index = 0;  // of the task's
  std::vector<WayDown> ways;
};

PickMiss miss_of(const InverseAnswer& answer) {
  using robot::InverseFailure;
  const PickFilter filter = answer.failure == InverseFailure::kBeyondLimits
                                ? PickFilter::kBeyondLimits
                                : PickFilter::kOutOfReach;
  return {filter, -answer.miss, answer.reason};
}

PickMiss miss_of(PickFilter filter, const JointPath& path) {
  return {filter, path.completed, path.reason};
}

class Picker {
 public:
  Picker(const RobotInWorld& robot, const robot::InverseKinematics& inverse, const PickTask& task,
         const PickOptions& options)
      : inverse_(inverse),
        task_(task),
        options_(options),
        scenes_(robot, task),
        ways_(scenes_, inverse, task, options),
        planner_(PlannerRegistry().create(options.planner)) {}

  PickMotion plan() {
    if (task_.grasps.empty()) return failed("there are no grasps");
    if (std::string problem = scenes_.reach().problem(task_.start); !problem.empty()) {
      return failed("at the start, " + problem);
    }
    misses_.resize(task_.grasps.size());
    tried_.assign(task_.grasps.size(), false);
    places_.resize(task_.grasps.size());
    std::vector<double> expected;
    for (const PickGrasp& grasp : task_.grasps) expected.push_back(grasp.expected_success);
    const auto tiers = success_tiers(expected, options_.success_for_path);
    for (std::size_t t = 0; t < tiers.size() && !(t > 0 && is_over_all()); ++t) {
      begin_slice(t + 1 == tiers.size());
      if (!plan_for(tiers[t])) continue;
      settle();
      return std::move(result_);
    }
    settle();
    return failed(rejection_problem(task_.grasps.size(), result_.rejections));
  }

 private:
  PickMotion failed(std::string problem) {
    result_.segments.clear();
    result_.problem = std::move(problem);
    return std::move(result_);
  }

  double elapsed() const { return std::chrono::duration<double>(Clock::now() - begin_).count(); }
  bool is_over_all() const { return options_.budget > 0 && elapsed() > options_.budget; }

  /// The time for one tier of grasps: all that is left for the last.
  void begin_slice(bool is_last) {
    slice_begin_ = elapsed();
    slice_ = (is_last ? 1 : kShareOfTier) * (options_.budget - slice_begin_);
  }
  bool is_over(double share) const {
    return options_.budget > 0 && elapsed() > slice_begin_ + share * slice_;
  }
  void lap(const char* name) {
    const double now = elapsed();
    const auto known = std::find_if(result_.times.begin(), result_.times.end(),
                                    [name](const PickStage& stage) { return stage.name == name; });
    if (known == result_.times.end()) {
      result_.times.push_back({name, now - last_lap_});
    } else {
      known->seconds += now - last_lap_;
    }
    last_lap_ = now;
  }

  /// The search's options with what is left of the tier's time.
  PathOptions searching() const {
    PathOptions path = options_.path;
    path.budget = options_.budget > 0 ? std::max(1e-6, slice_begin_ + slice_ - elapsed()) : 0;
    return path;
  }

  /// A motion for one of these grasps; false when there is none.
  bool plan_for(const std::vector<std::size_t>& tier) {
    goals_.clear();
    find_goals(tier);
    lap("goals");
    result_.goals = static_cast<int>(goals_.size());
    while (!goals_.empty()) {
      std::vector<Positions> ends;
      for (const Goal& goal : goals_) ends.push_back(goal.approach.front());
      JointPath reach = plan_path(*planner_, scenes_.reach(), task_.start, ends, searching());
      lap("reach");
      if (!reach.found()) {
        for (const Goal& goal : goals_) drop(goal.grasp, reach.reason);
        goals_.clear();
        break;
      }
      const Goal goal = goals_[static_cast<std::size_t>(reach.goal)];
      if (finish(goal, std::move(reach.waypoints))) return true;
      goals_.erase(goals_.begin() + reach.goal);
    }
    return false;
  }

  void find_goals(const std::vector<std::size_t>& tier) {
    for (const std::size_t i : tier) {
      tried_[i] = true;
      const bool enough = static_cast<int>(goals_.size()) >= options_.goals;
      if (enough || is_over(goals_.empty() ? 1 : kShareForGoals)) {
        misses_[i] = {PickFilter::kNotTried, 0,
                      enough ? "there were goals enough" : kNoTimeLeft.text};
        continue;
      }
      try_grasp(i);
    }
  }

  void try_grasp(std::size_t i) {
    const PickGrasp& grasp = task_.grasps[i];
    const InverseAnswer answer = inverse_.solve(grasp.X_BT, task_.start);
    if (answer.solutions.empty()) {
      misses_[i] = miss_of(answer);
      return;
    }
    int count = 0;
    bool place_known = false;
    for (const Positions& q : answer.solutions) {
      if (count >= options_.goals_per_grasp || static_cast<int>(goals_.size()) >= options_.goals ||
          is_over(1)) {
        break;
      }
      Goal goal;
      goal.grasp = i;
      PickMiss miss;
      if (!try_solution(grasp, q, goal, miss)) {
        if (misses_[i].text.empty() || miss.is_farther_than(misses_[i])) misses_[i] = miss;
        continue;
      }
      if (is_placed() && !place_known) {
        place_known = true;
        miss = find_place(grasp, goal.lift.back(), 0, places_[i]);
        if (places_[i].ways.empty()) {
          misses_[i] = miss.text.empty() ? kNoTimeLeft : miss;
          return;
        }
      }
      goals_.push_back(std::move(goal));
      ++count;
    }
    if (count == 0 && misses_[i].text.empty()) {
      misses_[i] = kNoTimeLeft;
    }
  }

  bool try_solution(const PickGrasp& grasp, const Positions& q, Goal& goal, PickMiss& miss) const {
    if (std::string problem = scenes_.approach().problem(q); !problem.empty()) {
      miss = {PickFilter::kGraspTouches, 0, problem};
      return false;
    }
    const Eigen::Vector3d back = -grasp.pregrasp_distance * grasp.approach_direction_B;
    JointPath away = ways_.straight(scenes_.approach(), q, moved_by(grasp.X_BT, back));
    if (!away.found()) {
      miss = miss_of(PickFilter::kApproach, away);
      return false;
    }
    if (std::string problem = scenes_.reach().problem(away.waypoints.back()); !problem.empty()) {
      miss = {PickFilter::kPregraspTouches, 0, problem};
      return false;
    }
    std::optional<RobotInWorld> carry;
    if (is_placed()) carry.emplace(scenes_.carry(grasp));
    auto [up, problem] =
        ways_.raised(scenes_.lift(grasp, q), q, grasp.X_BT, 0, carry ? &*carry : nullptr);
    if (!up.found()) {
      miss = miss_of(PickFilter::kLift, up);
      return false;
    }
    if (!problem.empty()) {
      miss = {PickFilter::kLift, 1, "when lifted, " + problem};
      return false;
    }
    goal.approach = std::move(away.waypoints);
    std::reverse(goal.approach.begin(), goal.approach.end());
    goal.lift = std::move(up.waypoints);
    return true;
  }

  bool is_placed() const { return !task_.X_BO_places.empty(); }

  /// The first place from `first` on that the object can be put down at; the farthest miss when
  /// there is none.
  PickMiss find_place(const PickGrasp& grasp, const Positions& seed, std::size_t first,
                      Place& place) const {
    PickMiss farthest{PickFilter::kPlace, 0, ""};
    const RobotInWorld carry = scenes_.carry(grasp);
    place.ways.clear();
    for (place.index = first; place.index < task_.X_BO_places.size(); ++place.index) {
      const PickMiss miss = ways_.down(
          grasp, seed, task_.X_BO_places[place.index], carry, [this] { return is_over(1); },
          &place.ways);
      if (!place.ways.empty()) return {};
      if (farthest.text.empty() || miss.passed > farthest.passed) farthest = miss;
    }
    return farthest;
  }

  /// The way on from a goal that was reached; false when there is none.
  bool finish(const Goal& goal, std::vector<Positions> reach) {
    const PickGrasp& grasp = task_.grasps[goal.grasp];
    result_.segments.clear();
    add(SegmentKind::kReach, std::move(reach), false);
    add(SegmentKind::kApproach, goal.approach, false);
    add(SegmentKind::kLift, goal.lift, true);
    if (is_placed() && !finish_at_place(goal)) return false;
    if (options_.acceleration.size() > 0) {
      time_segments(grasp);
      lap("timing");
    }
    result_.grasp = static_cast<int>(goal.grasp);
    return true;
  }

  /// Carry, place and retreat, to the first place that there is a path to.
  bool finish_at_place(const Goal& goal) {
    const PickGrasp& grasp = task_.grasps[goal.grasp];
    Place& place = places_[goal.grasp];
    const RobotInWorld scene = scenes_.carry(grasp);
    std::string problem;
    while (!place.ways.empty()) {
      std::vector<Positions> ends;
      for (const WayDown& way : place.ways) ends.push_back(way.down.front());
      JointPath carry = plan_path(*planner_, scene, goal.lift.back(), ends, searching());
      lap("carry");
      if (carry.found()) {
        const WayDown& way = place.ways[static_cast<std::size_t>(carry.goal)];
        add(SegmentKind::kCarry, std::move(carry.waypoints), true);
        add(SegmentKind::kPlace, way.down, true);
        add(SegmentKind::kRetreat, way.retreat, false);
        X_BO_ = way.X_BO;
        stands_ = way.stands;
        result_.place = static_cast<int>(place.index);
        return true;
      }
      if (problem.empty()) problem = carry.reason;
      find_place(grasp, goal.lift.back(), place.index + 1, place);
    }
    drop(goal.grasp, "on the way to the place, " + problem);
    return false;
  }

  void add(SegmentKind kind, std::vector<Positions> waypoints, bool holds) {
    result_.segments.push_back({kind, std::move(waypoints), holds, std::nullopt});
  }

  void time_segments(const PickGrasp& grasp) {
    TimingOptions straight = options_.timing;
    straight.speed_factor *= options_.straight_speed_factor;
    // Nothing of it may be lost where things are near.
    straight.deviation = std::min(straight.deviation, 1e-3);
    for (PickSegment& segment : result_.segments) {
      const std::vector<Positions>& way = segment.waypoints;
      const auto timed = [&](const RobotInWorld& scene) {
        segment.trajectory = blend_trajectory(scene, way, options_.acceleration, options_.timing);
      };
      const auto timed_straight = [&](const RobotInWorld& scene, bool is_guarded = false) {
        segment.trajectory = blend_trajectory(scene, way, options_.acceleration, straight);
        double most = options_.straight_speed;
        if (is_guarded && options_.guarded_speed > 0 &&
            !(most > 0 && most < options_.guarded_speed)) {
          most = options_.guarded_speed;
        }
        if (most <= 0) return;
        TimingOptions slower = straight;
        slower.speed_factor = most / tool_speed(*segment.trajectory);
        if (slower.speed_factor >= straight.speed_factor) return;
        segment.trajectory = blend_trajectory(scene, way, options_.acceleration, slower);
      };
      switch (segment.kind) {
        case SegmentKind::kReach:
          timed(scenes_.reach());
          break;
        case SegmentKind::kApproach:
          timed_straight(scenes_.approach(), true);
          break;
        case SegmentKind::kLift:
          timed_straight(scenes_.lift(grasp, way.front()));
          break;
        case SegmentKind::kCarry:
          timed(scenes_.carry(grasp));
          break;
        case SegmentKind::kPlace:
          timed_straight(scenes_.lift(grasp, way.back()));
          result_.place_share = share_at(*segment.trajectory, stands_);
          break;
        case SegmentKind::kRetreat:
          timed_straight(scenes_.retreat(X_BO_));
          break;
      }
    }
  }

  /// Share of a trajectory's time at which it is nearest to `q`; 1 when that is its end.
  static double share_at(const BlendedTrajectory& trajectory, const Positions& q) {
    constexpr int kSteps = 400;
    const double duration = trajectory.duration();
    double share = 1, least = (trajectory.at(duration).position - q).norm();
    for (int i = 1; i < kSteps; ++i) {
      const double off = (trajectory.at(duration * i / kSteps).position - q).norm();
      if (off >= least) continue;
      least = off;
      share = 1.0 * i / kSteps;
    }
    return share;
  }

  /// The greatest speed of the tool [m/s] where the fastest joint is at its velocity limit.
  double tool_speed(const BlendedTrajectory& trajectory) const {
    constexpr double kStep = 0.005;    // s
    constexpr double kSlowest = 1e-3;  // of the joints' limits: what stands has no direction
    const robot::KinematicChain& chain = inverse_.chain();
    double most = 1e-6;
    for (double time = kStep; time < trajectory.duration(); time += kStep) {
      const TrajectoryPoint at = trajectory.at(time);
      double share = 0;
      for (int k = 0; k < chain.size(); ++k) {
        share = std::max(share, std::abs(at.velocity[k]) /
                                    chain.joints()[static_cast<std::size_t>(k)].max_velocity);
      }
      if (share < kSlowest) continue;
      const Eigen::Vector3d way = chain.forward(at.position + kStep * at.velocity).translation() -
                                  chain.forward(at.position).translation();
      most = std::max(most, way.norm() / kStep / share);
    }
    return most;
  }

  void drop(std::size_t grasp, const std::string& reason) {
    misses_[grasp] = {PickFilter::kPath, 0, reason};
  }

  /// Every grasp that is of no use is counted once.
  void settle() {
    for (std::size_t i = 0; i < misses_.size(); ++i) {
      const bool is_goal =
          static_cast<int>(i) == result_.grasp ||
          std::any_of(goals_.begin(), goals_.end(), [i](const Goal& g) { return g.grasp == i; });
      if (!tried_[i]) {
        misses_[i] = {
            PickFilter::kNotTried, 0,
            result_.grasp >= 0 ? "a better one can be executed" : "the budget was used up"};
      }
      if (!is_goal) ledger_.add(misses_[i]);
    }
    result_.rejections = ledger_.rejections();
  }

  const robot::InverseKinematics& inverse_;
  const PickTask& task_;
  const PickOptions& options_;
  PickScenes scenes_;
  PickWays ways_;
  std::unique_ptr<const PathPlanner> planner_;
  Clock::time_point begin_ = Clock::now();
  double last_lap_ = 0;
  double slice_begin_ = 0, slice_ = 0;  // s, of the present tier
  std::vector<Goal> goals_;
  std::vector<PickMiss> misses_;                      // of each grasp
  std::vector<bool> tried_;                           // of each grasp
  std::vector<Place> places_;                         // of each grasp
  RigidTransform X_BO_ = RigidTransform::Identity();  // of the object at its place
  Positions stands_;                                  // when it is there
  PickLedger ledger_;
  PickMotion result_;
};

}  // namespace

PickMotion plan_pick(const RobotInWorld& robot, const robot::InverseKinematics& inverse,
                     const PickTask& task, const PickOptions& options) {
  check_pick(robot, inverse, task, options);
  return Picker(robot, inverse, task, options).plan();
}

}  // namespace prehend::motion
