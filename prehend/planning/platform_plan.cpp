#include "prehend/planning/platform_plan.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstddef>
#include <utility>

#include <fmt/format.h>

#include "prehend/geometry/gravity.h"
#include "prehend/motion/pick_ledger.h"
#include "prehend/text/require.h"

namespace prehend::planning {
namespace {

using std::chrono::steady_clock;

constexpr double kLeastFriction = 0.02;  // of anything on foam or rubber
constexpr double kTwoPads = 2;           // that share the load
constexpr double kSureOfShape = 0.5;     // below, the prediction is not trusted
constexpr double kSureOfOne = 0.9;       // from there on, it is not two things that look like one
constexpr double kPushedThere = 0.15;    // m, of a push's end to what it has moved
constexpr double kSameHold = 0.02;       // m, between tools that hold the same, seen from above

double seconds_since(steady_clock::time_point begin) {
  return std::chrono::duration<double>(steady_clock::now() - begin).count();
}

bool can_be_executed(const PlatformPlan& plan) {
  return std::any_of(plan.picks.begin(), plan.picks.end(),
                     [](const PlannedPick& pick) { return !pick.segments.empty(); });
}

/// Whether candidates between those that were tried may be grasps: enough of them fell by where the
/// hand was, not by what it is.
bool finer_may_help(const PlatformPlan& plan) {
  constexpr double kEnough = 0.1;  // of those that the arm's directions leave
  int tried = 0, misplaced = 0;
  for (const grasp::Rejection& rejection : plan.rejections) {
    switch (rejection.reason) {
      case grasp::Reason::kDirection:
      case grasp::Reason::kWorkspace:
      case grasp::Reason::kArm:
      case grasp::Reason::kEnough:
        break;
      case grasp::Reason::kTooWide:
      case grasp::Reason::kTooHeavy:
      case grasp::Reason::kTooWeak:
      case grasp::Reason::kNoTime:
        tried += rejection.count;
        break;
      default:
        tried += rejection.count;
        misplaced += rejection.count;
    }
  }
  return misplaced > kEnough * tried;
}

void refine(int times, grasp::PlannerOptions* grasps) {
  grasp::GeneratorOptions& candidates = grasps->candidates;
  for (int* steps : {&candidates.samples, &candidates.approaches, &candidates.rolls,
                     &candidates.standoffs, &candidates.circles.directions_per_circle,
                     &candidates.circles.rolls, &candidates.circles.standoffs}) {
    *steps *= times;
  }
}

void add_remedies(Remedies remedies, steady_clock::time_point asked, PlatformPlan* plan) {
  if (const std::string help = in_words(remedies); !help.empty()) plan->problem += ". " + help;
  plan->remedies = std::move(remedies);
  plan->remedy_time = seconds_since(asked);
}

}  // namespace

void within_load(const grasp::LoadBounds& load, double volume, PlatformPlanOptions* options,
                 robot::HandModel* hand) {
  grasp::PlannerOptions& grasps = options->grasps;
  if (load.mass.is_known()) {
    const grasp::Interval density =
        grasp::within({grasps.hollow_share * grasps.density, grasps.density},
                      {load.mass.low / volume, load.mass.high / volume});
    grasps.density = density.high;
    grasps.hollow_share = std::clamp(density.low / density.high, 0.01, 1.0);
  }
  if (!load.friction.is_known()) return;
  grasp::UncertaintyOptions& disturbed = grasps.uncertainty;
  const grasp::Interval friction =
      grasp::within({disturbed.least_friction, disturbed.largest_friction}, load.friction);
  disturbed.least_friction = std::max(kLeastFriction, friction.low);
  disturbed.largest_friction = std::max(kLeastFriction, friction.high);
  // What was assumed is on the safe side; what was felt goes before it.
  const auto felt = [&](double assumed) {
    return std::max(kLeastFriction, std::clamp(assumed, load.friction.low, load.friction.high));
  };
  grasps.pads.friction = felt(grasps.pads.friction);
  hand->friction = felt(hand->friction);
  if (options->touch) options->touch->friction = felt(options->touch->friction);
  if (!(options->grip_force > 0) || !std::isfinite(load.friction.high)) return;
  const double weight = grasps.density * volume * (geometry::kGravity + grasps.lift_acceleration);
  options->grip_force =
      std::max(options->grip_force, grasps.safety_factor * weight / (kTwoPads * hand->friction));
}

void PlatformPlanOptions::validate() const {
  grasps.validate();
  place.validate();
  const text::Require require{"PlatformPlanOptions."};
  require(motions > 0, "motions must be positive");
  require(shape_confidence >= 0 && shape_confidence <= 1, "shape_confidence must be from 0 to 1");
  require(finer > 0 && finer <= 10, "finer must be from 1 to 10");
  require(std::isfinite(grip_force) && grip_force >= 0, "grip_force must not be negative");
  if (touch) touch->validate();
  decision.validate();
  probe.validate();
  if (push) push->validate();
  views.validate();
  ViewOptions::knobs(look, text::CheckKnobs{"PlatformPlanOptions.look."});
  RemedyOptions::knobs(remedies, text::CheckKnobs{require.of});
}

PlatformPlanner::PlatformPlanner(robot::Platform platform)
    : platform_(std::move(platform)), hand_(platform_.hand) {}

void PlatformPlanner::set_gripper(const robot::GripperModel& gripper) {
  platform_.set_gripper(gripper);
  hand_ = grasp::HandToClose(platform_.hand);
}

PlatformPlan PlatformPlanner::plan(const surface::ObjectModel& object,
                                   const geometry::Plane& table_W, const Neighbours& neighbours,
                                   const grasp::Reachability& reachability,
                                   const robot::Positions& start, const PlatformPlanOptions& given,
                                   grasp::GraspDatabase* database,
                                   const std::optional<grasp::PlacedObject>& known) const {
  given.validate();
  const auto begin = steady_clock::now();
  PlatformPlanOptions options = given;
  // The hand with this object's friction.
  robot::HandModel model = platform_.hand;
  std::optional<grasp::HandToClose> rubbing;
  if (given.load.is_known() && object.mass_properties.volume > 0) {
    within_load(given.load, object.mass_properties.volume, &options, &model);
    if (model.friction != platform_.hand.friction) rubbing.emplace(model);
  }
  const grasp::HandToClose& hand = rubbing ? *rubbing : hand_;
  grasp::Obstacles obstacles;
  obstacles.meshes_W = platform_.hand.gripper ? neighbours.meshes_W : neighbours.pieces_W;
  const grasp::Reachability reach = within_reach(reachability, platform_);
  const PlatformScene scene{table_W, object.convex_pieces_W, neighbours.pieces_W};
  grasp::PlannerOptions reaching = options.grasps;
  reaching.reaches = arm_reach_over_table(platform_, scene, options.arm);
  if (options.viewing) {
    options.arm.inspection =
        HeldInspection{*options.viewing, surface_patches(object), object.mesh_W, options.views};
  }
  Unreached unreached;
  bool has_grasps = false;  // of the hand, at the last attempt
  const auto attempt = [&](const grasp::PlannerOptions& candidates) {
    grasp::GraspPlan grasps =
        database && known ? plan_grasps_with_memory(*database, *known, object, table_W, obstacles,
                                                    hand, reach, candidates)
                          : plan_grasps(object, table_W, obstacles, hand, reach, candidates);
    PlatformPlan plan;
    plan.rejections = std::move(grasps.rejections);
    plan.candidates = grasps.candidates;
    plan.outcome = grasps.outcome;
    plan.problem = grasps.problem;
    for (grasp::Grasp& grasp : grasps.grasps) {
      plan.robustness = std::max(plan.robustness, grasp.robustness);
      if (!platform_.hand.gripper) grasp.force = options.grip_force;
    }
    plan.grasp_time = seconds_since(begin);
    has_grasps = !grasps.grasps.empty();
    if (has_grasps) {
      unreached = add_motions(std::move(grasps.grasps), scene, start, options, &plan);
    }
    return plan;
  };
  PlatformPlan plan = attempt(reaching);
  // Without a free place to put it, none of its grasps is executed.
  const bool may_help = has_grasps ? !unreached.grasps.empty() : finer_may_help(plan);
  if (!can_be_executed(plan) && options.finer > 1 && reaching.given_W.empty() && may_help) {
    grasp::PlannerOptions finer = reaching;
    refine(options.finer, &finer);
    if (finer.budget > 0) finer.budget = std::max(1e-3, finer.budget - plan.grasp_time);
    Unreached before = std::exchange(unreached, {});
    const bool had_grasps = has_grasps;
    PlatformPlan second = attempt(finer);
    if (can_be_executed(second)) {
      plan = std::move(second);
    } else {
      plan.grasp_time = seconds_since(begin);
      unreached = std::move(before);
      has_grasps = had_grasps;
    }
  }
  if (options.remedies.budget > 0 && !can_be_executed(plan)) {
    const auto asked = steady_clock::now();
    if (!unreached.grasps.empty()) {
      add_remedies(remedies_for_motion(platform_, start, unreached.grasps, scene, unreached.arm,
                                       options.remedies),
                   asked, &plan);
    } else if (!has_grasps) {
      add_remedies(remedies_for_grasps(object, table_W, obstacles, model, reach, reaching,
                                       plan.rejections, options.remedies),
                   asked, &plan);
    }
  }
  std::vector<const grasp::Grasp*> executable;
  for (const PlannedPick& pick : plan.picks) {
    if (!pick.segments.empty()) executable.push_back(&pick.grasp);
  }
  if (options.push) add_push(hand, object, scene, start, options, &plan);
  if (!options.probes.empty() && !executable.empty()) {
    add_probe(hand, object, scene, start, options, &plan);
  }
  LookChances look;
  if (!executable.empty()) {
    if (options.carried_camera) {
      add_look(object, scene, start, options, &plan);
      look = {plan.look.apart, plan.look.from, plan.look.problem};
    } else if (platform_.X_FC) {
      look.problem = "nothing is known of the camera that the arm carries";
    }
  }
  plan.choices = decide_on(object, executable, platform_.hand.gripper.has_value(), options.decision,
                           plan.probe.stops, look);
  if (options.touch) predict_touch(object, table_W, options, &plan);
  return plan;
}

// Of an unsure shape, grasps that hold the same of it are planned together: what they hold is what
// is put down. Else there is one turn.
std::vector<PlatformPlanner::Turn> PlatformPlanner::turns(
    std::vector<grasp::Grasp> grasps, const PlatformScene& scene,
    const PlatformPlanOptions& options) const {
  const bool has_place = options.place.given_W || options.place.region_W;
  if (options.shape_confidence >= kSureOfShape || !has_place) {
    std::vector<Turn> one(1);
    one.front() = {std::move(grasps), free_places_for(platform_, scene, options.place)};
    return one;
  }
  std::vector<Turn> turns;
  for (grasp::Grasp& grasp : grasps) {
    const auto same = std::find_if(turns.begin(), turns.end(), [&grasp](const Turn& turn) {
      const Eigen::Vector3d apart =
          turn.grasps.front().X_WG.translation() - grasp.X_WG.translation();
      return apart.head<2>().norm() < kSameHold;
    });
    if (same != turns.end()) {
      same->grasps.push_back(std::move(grasp));
      continue;
    }
    PlaceOptions place = options.place;
    place.middle_W = grasp.X_WG.translation().head<2>();
    turns.push_back({{}, free_places_for(platform_, scene, place)});
    turns.back().grasps.push_back(std::move(grasp));
  }
  return turns;
}

// The grasps that the arm can execute, best first, and then the others; or why there is none.
PlatformPlanner::Unreached PlatformPlanner::add_motions(std::vector<grasp::Grasp> grasps,
                                                        const PlatformScene& scene,
                                                        const robot::Positions& start,
                                                        const PlatformPlanOptions& options,
                                                        PlatformPlan* plan) const {
  std::vector<Turn> turns = this->turns(std::move(grasps), scene, options);
  const std::string no_place = turns.front().places.problem;
  std::size_t asked = 0;
  std::erase_if(turns, [&](const Turn& turn) {
    asked += turn.grasps.size();
    if (turn.places.problem.empty()) return false;
    asked -= turn.grasps.size();
    motion::add_rejections(
        {{motion::PickFilter::kPlace, static_cast<int>(turn.grasps.size()), turn.places.problem}},
        &plan->arm_rejections);
    return true;
  });
  if (turns.empty()) {
    plan->outcome = grasp::PlanOutcome::kUngraspable;
    plan->problem = no_place + ". " + kPlaceMend;
    return {};
  }
  PlatformPickOptions arm = options.arm;
  if (platform_.hand.gripper) arm.shift = 0;  // its jaws meet in the middle
  arm.guarded = options.shape_confidence < kSureOfOne;
  std::string arm_problem;
  Unreached unreached;
  double in_vain = 0;  // s
  for (std::size_t t = 0; t < turns.size();) {
    Turn& turn = turns[t];
    const bool is_first_try = plan->picks.empty();
    if (turn.grasps.empty() || plan->picks.size() >= static_cast<std::size_t>(options.motions)) {
      ++t;
      continue;
    }
    std::vector<PlatformGrasp> poses;
    for (const grasp::Grasp& grasp : turn.grasps) poses.push_back(to_pick(grasp));
    arm.moves_W = turn.places.moves_W;
    if (const double budget = options.arm.pick.budget; budget > 0) {
      arm.pick.budget = std::max(1e-3, budget - in_vain);
    }
    const auto begin = steady_clock::now();
    PlatformPick pick = plan_platform_pick(platform_, start, poses, scene, arm);
    if (is_first_try) motion::add_rejections(pick.motion.rejections, &plan->arm_rejections);
    if (!pick.motion.found()) {
      in_vain += seconds_since(begin);
      if (arm_problem.empty()) arm_problem = pick.motion.problem;
      if (is_first_try && unreached.grasps.empty()) unreached = {std::move(poses), arm};
      ++t;
      continue;
    }
    PlannedPick planned;
    planned.grasp = std::move(turn.grasps[static_cast<std::size_t>(pick.grasp)]);
    planned.segments = std::move(pick.motion.segments);
    planned.shifts = std::move(pick.shifts);
    planned.views = std::move(pick.views);
    planned.place_share = pick.motion.place_share;
    if (pick.motion.place >= 0) {
      planned.move_W = arm.moves_W[static_cast<std::size_t>(pick.motion.place)];
    }
    plan->picks.push_back(std::move(planned));
    turn.grasps.erase(turn.grasps.begin() + pick.grasp);
  }
  if (plan->picks.empty()) {
    plan->outcome = grasp::PlanOutcome::kUngraspable;
    plan->problem = fmt::format("the arm can execute none of {} grasps: {}", asked, arm_problem);
    return unreached;
  }
  for (Turn& turn : turns) {
    for (grasp::Grasp& grasp : turn.grasps) {
      plan->picks.push_back({std::move(grasp), {}, {}, std::nullopt, 1, {}, {}});
    }
  }
  return {};
}

void PlatformPlanner::add_probe(const grasp::HandToClose& hand, const surface::ObjectModel& object,
                                const PlatformScene& scene, const robot::Positions& start,
                                const PlatformPlanOptions& options, PlatformPlan* plan) const {
  const auto begin = steady_clock::now();
  plan->probe =
      plan_probe(platform_, hand, start, options.probes, object, scene, options.arm, options.probe);
  plan->probe_time = seconds_since(begin);
}

void PlatformPlanner::add_push(const grasp::HandToClose& hand, const surface::ObjectModel& object,
                               const PlatformScene& scene, const robot::Positions& start,
                               const PlatformPlanOptions& options, PlatformPlan* plan) const {
  const bool is_blocked = std::any_of(plan->rejections.begin(), plan->rejections.end(),
                                      [](const grasp::Rejection& rejection) {
                                        return rejection.reason == grasp::Reason::kObstacle ||
                                               rejection.reason == grasp::Reason::kFingerObstacle;
                                      });
  const bool is_unsure = options.shape_confidence < kSureOfShape;
  if (is_blocked && !is_unsure && can_be_executed(*plan)) return;
  // What may be several things also where there are grasps, which may all fail.
  if (!is_blocked && !is_unsure) {
    // One thing with room about it stays what it is. Two that look like one are parted once or not.
    const bool was_pushed = std::any_of(
        options.push->made.begin(), options.push->made.end(), [&](const PushLine& line) {
          return (line.end_W - middle_of(scene.object_pieces_W)).norm() < kPushedThere;
        });
    if (can_be_executed(*plan) || options.shape_confidence >= kSureOfOne || was_pushed) return;
  }
  const auto begin = steady_clock::now();
  plan->push = plan_push(platform_, hand, start, object, scene, options.arm, *options.push);
  if (!is_blocked) plan->push.worth *= 1 - options.shape_confidence;
  plan->push_time = seconds_since(begin);
}

void PlatformPlanner::add_look(const surface::ObjectModel& object, const PlatformScene& scene,
                               const robot::Positions& start, const PlatformPlanOptions& options,
                               PlatformPlan* plan) const {
  const auto begin = steady_clock::now();
  plan->look = plan_look(platform_, start, *options.carried_camera, object, scene, options.arm,
                         options.look);
  plan->look_time = seconds_since(begin);
}

void PlatformPlanner::predict_touch(const surface::ObjectModel& object,
                                    const geometry::Plane& table_W,
                                    const PlatformPlanOptions& options, PlatformPlan* plan) const {
  // A gripper that regulates its grip feels what its closing was planned by.
  if (platform_.hand.pads.empty() || platform_.hand_port == robot::HandPort::kGripper) return;
  const auto begin = steady_clock::now();
  TouchPredictionOptions touch = *options.touch;
  if (options.grasps.budget > 0)
    touch.budget = std::max(options.grasps.budget - plan->grasp_time, 1e-6);
  std::vector<grasp::Grasp> grasps;
  for (const PlannedPick& pick : plan->picks) {
    if (!pick.segments.empty()) grasps.push_back(pick.grasp);
  }
  std::vector<PredictedTouch> touches = add_touch(platform_.hand, object, table_W, touch, &grasps);
  // They are the first of the list.
  for (std::size_t i = 0; i < grasps.size(); ++i) {
    plan->picks[i].grasp.predicted = grasps[i].predicted;
    plan->picks[i].touch = std::move(touches[i]);
  }
  plan->touch_time = seconds_since(begin);
}

}  // namespace prehend::planning
