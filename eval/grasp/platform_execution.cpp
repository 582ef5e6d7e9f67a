#include "eval/grasp/platform_execution.h"

#include <algorithm>
#include <utility>

#include <fmt/format.h>

#include "prehend/control/planned_grasp.h"
#include "prehend/geometry/mesh_query.h"

namespace prehend::eval {
namespace {

using control::Phase;
using control::SurpriseKind;
using geometry::RigidTransform;

constexpr double kRaisedAtLeast = 0.05;  // m, as eval_platform
constexpr double kStands = 0.01;         // m, over the table, of what was put down
constexpr double kSettled = 0.5;         // s, after the end of the cycle
constexpr double kPatience = 1;          // s, for a new look, which takes no time here

control::ArmCycleOptions cycle_options(const ExecutionChoice& choice) {
  control::ArmCycleOptions options;
  options.reacts = choice.reacts;
  options.task = choice.task;
  options.look_timeout = kPatience;
  return options;
}

double mean_distance(const std::vector<Eigen::Vector3d>& points_W,
                     const geometry::MeshQuery& surface_W) {
  double sum = 0;
  for (const auto& p_W : points_W) sum += surface_W.nearest(p_W)->distance;
  return sum / static_cast<double>(points_W.size());
}

}  // namespace

PlatformExecution::PlatformExecution(const robot::Platform& platform, const std::string& home,
                                     const ExecutionChoice& choice, const TrueObject& truth)
    : platform_(platform),
      truth_(truth),
      world_(world_under_test(platform, home, truth)),
      cycle_(world_->robot(), cycle_options(choice)),
      attempt_watch_(platform, control::ArmCycleOptions().contact_force),
      start_(world_->object()) {
  if (auto judge = control::GripJudge::of(platform)) cycle_.judge_grips(std::move(*judge));
}

void PlatformExecution::run(const planning::PlatformPlan& plan, const PlanAgain& plan_again) {
  cycle_.run(
      to_try(plan), [&] { return to_try(plan_again(moved(), attempt_watch_.attempt())); },
      [this] { watch(); });
  control::CycleWorld& robot = world_->robot();
  robot.advance(static_cast<int>(std::ceil(kSettled / robot.step_time())));
}

void PlatformExecution::record(GraspTrial* trial) const {
  const control::CycleResult& result = cycle_.cycle().result();
  const ObjectReading end = world_->object();
  trial->attempts = result.attempts;
  trial->touches = result.touches;
  trial->plans = result.plans;
  trial->stage = stage_;
  trial->outcome = stage_.empty() ? result.reason : why_;
  trial->lifted =
      result.success() && raised_ >= kRaisedAtLeast && end.height < kStands && !end.touches_robot;
  if (result.success() && !trial->lifted && stage_.empty()) {
    trial->stage = kSaidUntruly;
    trial->outcome = fmt::format(
        "success was said, but it was raised by {:.0f} mm and is {:.0f} mm over the table{}",
        1e3 * raised_, 1e3 * end.height, end.touches_robot ? ", at the robot" : "");
  }
  trial->surprises = cycle_.cycle().surprises();
  for (const control::Surprise& s : trial->surprises) {
    if (s.kind == SurpriseKind::kOpeningAtContact) trial->opening_error = s.felt - s.predicted;
    if (s.kind == SurpriseKind::kContactArea && s.felt > 0) {
      trial->area_error = s.predicted / s.felt - 1;
    }
  }
  if (!grasp_) return;
  trial->slip = slip_;
  trial->contact_error =
      mean_distance(grasp::contact_points(*grasp_),
                    geometry::MeshQuery(geometry::transformed(truth_.mesh_W, X_moved_)));
  trial->robustness = grasp_->robustness;
  trial->first_robustness = first_robustness_;
  trial->guessed_contact = grasp_->guessed_contact;
}

RigidTransform PlatformExecution::moved() const {
  return world_->object().X_WB * start_.X_WB.inverse();
}

// As the cycle's node: what has no motion of the arm cannot be executed.
control::GraspsToTry PlatformExecution::to_try(const planning::PlatformPlan& plan) {
  control::GraspsToTry grasps{{}, grasp::in_words(plan), control::advice_of(platform_, plan)};
  if (!plan.picks.empty()) tried_.clear();
  for (const planning::PlannedPick& pick : plan.picks) {
    if (pick.segments.empty()) continue;
    grasps.grasps.push_back(control::arm_grasp(platform_, pick));
    tried_.push_back(pick.grasp);
  }
  return grasps;
}

void PlatformExecution::watch() {
  const control::ArmCycle& cycle = cycle_.cycle();
  attempt_watch_.step(cycle, cycle_.percepts());
  const ObjectReading object = world_->object();
  raised_ = std::max(raised_, object.height - start_.height);
  const int attempts = cycle.result().tries();
  if (attempts != attempts_) {
    attempts_ = attempts;
    X_moved_ = moved();
    grasp_ = tried_.at(static_cast<std::size_t>(cycle.grasp_index()));
    p_HB_.reset();
  }
  if (cycle.result().attempts == 1) first_robustness_ = grasp_->robustness;
  const bool failed = !cycle.failure().empty() || cycle.phase() == Phase::kFailed;
  if (failed && attempts_ <= 1 && stage_.empty()) {
    stage_ = to_string(phase_);
    why_ = cycle.failure().empty() ? cycle.result().reason : cycle.failure();
  }
  phase_ = cycle.phase();
  if (phase_ != Phase::kLift && phase_ != Phase::kMove) return;
  const Eigen::Vector3d p_HB = object.X_HB.translation();
  if (!p_HB_) p_HB_ = p_HB;
  slip_ = (p_HB - *p_HB_).norm();
}

}  // namespace prehend::eval
