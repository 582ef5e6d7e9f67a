#include "prehend/control/arm_cycle.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/geometry/gravity.h"
#include "prehend/text/require.h"

namespace prehend::control {
namespace {

std::vector<double> values_of(const Eigen::VectorXd& vector) {
  return {vector.begin(), vector.end()};
}

std::vector<GraspPose> poses_of(const std::vector<ArmGrasp>& grasps) {
  std::vector<GraspPose> poses;
  for (const ArmGrasp& grasp : grasps) poses.push_back(grasp.pose);
  return poses;
}

}  // namespace

void ArmCycleOptions::validate() const {
  const text::Require require{"ArmCycleOptions."};
  require(std::isfinite(contact_force) && contact_force > 0, "contact_force must be positive");
  require(std::isfinite(collision_force) && collision_force > 0,
          "collision_force must be positive");
  require(opening_speed > 0 && opening_speed <= 1, "opening_speed must be in (0, 1]");
  require(closing_speed > 0 && closing_speed <= 1, "closing_speed must be in (0, 1]");
  require(std::isfinite(overrun) && overrun >= 0, "overrun must not be negative");
  require(std::isfinite(gather) && gather >= 0, "gather must not be negative");
  require(std::isfinite(settle_time) && settle_time >= 0, "settle_time must not be negative");
  require(std::isfinite(rest_time) && rest_time >= 0, "rest_time must not be negative");
  require(std::isfinite(check_time) && check_time >= 0, "check_time must not be negative");
  require(std::isfinite(motion_timeout) && motion_timeout > 0, "motion_timeout must be positive");
  require(std::isfinite(largest_detour) && largest_detour > 0, "largest_detour must be positive");
  require(largest_attempts > 0, "largest_attempts must be positive");
  require(std::isfinite(stale_time) && stale_time > 0, "stale_time must be positive");
  require(std::isfinite(answer_time) && answer_time > 0, "answer_time must be positive");
  require(std::isfinite(look_timeout) && look_timeout >= 0, "look_timeout must not be negative");
  holding.validate();
  tolerances.validate();
}

std::string described(const ArmGrasp& grasp, int index) {
  return fmt::format("grasp {} (score {:.2f}, {})", index, grasp.score,
                     grasp.robustness < 0 ? std::string("robustness not assessed")
                                          : fmt::format("held in {:.0f} % of the disturbed trials",
                                                        100 * grasp.robustness));
}

ArmCycle::ArmCycle(const ArmCycleOptions& options, ArmPort& arm, HandPort& hand)
    : Cycle(options.tolerances),
      options_(options),
      arm_(arm),
      hand_(hand),
      holding_(options.holding) {
  options.validate();
}

bool ArmCycle::moves_hand(Step step) {
  return step == Step::kOpen || step == Step::kGather || step == Step::kClose ||
         step == Step::kRelease || step == Step::kGiveUpOpen;
}

bool ArmCycle::waits(Step step) {
  return step == Step::kRest || step == Step::kSettle || step == Step::kCheck ||
         step == Step::kVerify || step == Step::kLook;
}

Phase ArmCycle::phase_of(Step step) {
  switch (step) {
    case Step::kWaiting:
    case Step::kLook:
      return Phase::kWaiting;
    case Step::kOpen:
    case Step::kReach:
    case Step::kRest:
    case Step::kApproach:
      return Phase::kApproach;
    case Step::kGather:
    case Step::kClose:
    case Step::kSettle:
      return Phase::kGrasp;
    case Step::kLift:
    case Step::kCheck:
      return Phase::kLift;
    case Step::kCarry:
    case Step::kPlace:
      return Phase::kMove;
    case Step::kRelease:
    case Step::kRetreat:
    case Step::kVerify:
    case Step::kGiveUpOpen:
    case Step::kGoBack:
      return Phase::kRelease;
    case Step::kDone:
      return Phase::kDone;
    case Step::kFailed:
      return Phase::kFailed;
  }
  return Phase::kFailed;
}

Phase ArmCycle::phase() const { return phase_of(step_); }

void ArmCycle::enter(Step step, const std::string& detail) {
  step_ = step;
  entered(detail);
}

void ArmCycle::start(std::vector<ArmGrasp> grasps, const std::string& problem) {
  grasps_ = std::move(grasps);
  order_.start(poses_of(grasps_));
  clear();
  step_ = Step::kWaiting;
  if (grasps_.empty()) return finish(false, problem.empty() ? "the plan has no grasps" : problem);
  step_waiting();
}

std::vector<InputAge> ArmCycle::inputs() {
  const auto age = [](bool has_come, double seconds) {
    return has_come ? std::optional(seconds) : std::nullopt;
  };
  return {{"the joints' states", age(!percepts_.names.empty(), percepts_.joints_age),
           options_.stale_time},
          {"the wrist's force", age(percepts_.wrist_force.has_value(), percepts_.wrist_age),
           options_.stale_time},
          {"the server of the arm's motion", arm_.answer_age(), options_.answer_time},
          {"the server of the hand's motion", hand_.answer_age(), options_.answer_time}};
}

void ArmCycle::step_waiting() {
  if (grasps_.empty()) return;  // not started
  const std::vector<InputAge> missing = stale_inputs(inputs());
  if (missing.empty()) return begin_grasp(0);
  detail_ = "waiting for " + names_of(missing);
  if (spent() > options_.motion_timeout) {
    finish(false, "nothing was moved, for want of " + describe(missing));
  }
}

bool ArmCycle::stop_when_lost() {
  if (step_ == Step::kLook) return false;
  const std::vector<InputAge> lost = watch_.lost(now(), inputs());
  if (lost.empty()) return false;
  abort("lost " + describe(lost) + " while " + detail_ + "; arm and hand were stopped");
  return true;
}

void ArmCycle::begin_grasp(int index) {
  watch_.begin(now());
  begin_attempt(index);
  order_.begin(index);
  gone_.clear();
  holding_.begin();
  open_hand();
  enter(Step::kOpen, described(grasp(), index) + ": opening the hand");
}

void ArmCycle::follow(const JointPath& path, double contact_force) {
  refused_.clear();
  try {
    const JointPath from_here =
        joined(path, percepts_.names, percepts_.positions, options_.largest_detour);
    gone_.push_back(from_here);
    arm_.follow(from_here, contact_force);
  } catch (const std::invalid_argument& error) {
    refused_ = error.what();
  }
}

const JointPath* ArmCycle::segment(const std::string& name) const {
  for (const auto& [segment_name, path] : grasp().segments) {
    if (segment_name == name) return &path;
  }
  return nullptr;
}

bool ArmCycle::begin_segment(const std::string& name, Step step, double contact_force) {
  enter(step, "arm: " + name);
  const JointPath* path = segment(name);
  if (path) follow(*path, contact_force);
  return path != nullptr;
}

void ArmCycle::open_hand() {
  hand_.move(grasp().hand_joints, values_of(grasp().hand.open), options_.opening_speed, false);
}

void ArmCycle::gather() {
  if (options_.gather == 0) return close();
  hand_.move(grasp().hand_joints, values_of(grasp().hand.at(-options_.gather)),
             options_.closing_speed, true);
  enter(Step::kGather, "gathering the fingers round the object");
}

void ArmCycle::close() {
  hand_.move(grasp().hand_joints, values_of(grasp().hand.at(options_.overrun)),
             options_.closing_speed, true);
  enter(Step::kClose, "closing the fingers");
}

void ArmCycle::give_up(const std::string& reason) {
  fail_attempt(static_cast<int>(step_), fmt::format("grasp {}: {}", grasp_index(), reason),
               SurpriseKind::kMotion, "opens and goes back");
  arm_.stop();
  open_hand();
  enter(Step::kGiveUpOpen, failure() + "; opening");
}

void ArmCycle::go_back() {
  if (gone_.empty()) {
    order_.fail(grasp_index());
    if (options_.look_timeout > 0 && result_.attempts < options_.largest_attempts) {
      return enter(Step::kLook, failure() + "; looking again");
    }
    return next_grasp("");
  }
  JointPath back = reversed(gone_.back());
  gone_.pop_back();
  enter(Step::kGoBack, "going back the way it came");
  follow(back, 0);
  // It was pushed: follow() counts what is gone, and this is no way that is to be gone back.
  if (refused_.empty()) gone_.pop_back();
}

std::optional<double> ArmCycle::looks_since() const {
  return step_ == Step::kLook ? std::optional(entered_) : std::nullopt;
}

void ArmCycle::take_plan(std::vector<ArmGrasp> grasps, const std::string& problem) {
  if (step_ != Step::kLook) return;
  if (grasps.empty()) {
    return next_grasp("the new look gives no grasp" + (problem.empty() ? "" : ": " + problem));
  }
  grasps_ = std::move(grasps);
  order_.take(poses_of(grasps_));
  ++result_.plans;
  begin_grasp(order_.next().value_or(0));
}

// `why` it is not a grasp of a new look, in words; empty: nobody looked.
void ArmCycle::next_grasp(const std::string& why) {
  const std::optional<int> next = order_.next();
  const bool out_of_date = options_.only_seen_again && !why.empty();
  if (!next || out_of_date || result_.attempts >= options_.largest_attempts) {
    return finish(false, failed_attempts().text() + (why.empty() ? "" : "; " + why));
  }
  begin_grasp(*next);
  if (!why.empty()) detail_ = why + ": the next grasp of the plan before; " + detail_;
}

// A segment that the plan does not have ends at once.
MotionStatus ArmCycle::motion_status() {
  static const std::pair<Step, const char*> kSegments[] = {
      {Step::kReach, "reach"}, {Step::kApproach, "approach"}, {Step::kLift, "lift"},
      {Step::kCarry, "carry"}, {Step::kPlace, "place"},       {Step::kRetreat, "retreat"}};
  if (moves_hand(step_)) return hand_.motion();
  if (waits(step_)) return MotionStatus::kReached;
  if (!refused_.empty()) return MotionStatus::kFailed;
  bool planned = step_ == Step::kGoBack;
  for (const auto& [step, name] : kSegments) {
    planned = planned || (step == step_ && segment(name) != nullptr);
  }
  return planned ? arm_.motion() : MotionStatus::kReached;
}

void ArmCycle::step(const ArmPercepts& percepts) {
  advance_to(percepts.time);
  percepts_ = percepts;
  if (finished()) return;
  if (step_ == Step::kWaiting) return step_waiting();
  if (stop_when_lost()) return;
  if (watch_held()) return;
  const MotionStatus status = motion_status();
  const bool gives_up = step_ == Step::kGiveUpOpen || step_ == Step::kGoBack;
  if (status == MotionStatus::kMoving) {
    if (spent() <= options_.motion_timeout) return;
    arm_.stop();
    hand_.stop();
    if (gives_up) return finish(false, failure() + "; " + detail_ + " took too long");
    return give_up(detail_ + " took too long");
  }
  if (status == MotionStatus::kFailed) {
    std::string why = detail_ + ": ";
    why += moves_hand(step_) ? hand_.problem() : (refused_.empty() ? arm_.problem() : refused_);
    if (gives_up) return finish(false, failure() + "; " + why);
    if (step_ == Step::kRetreat) {
      add_surprise(SurpriseKind::kMotion, 1, 0, "ends");
      return finish(false, why);
    }
    return give_up(why);
  }
  if (status == MotionStatus::kContact && !moves_hand(step_) && !reacts_to_contact()) {
    const std::string why =
        fmt::format("{}: the arm hit something, the wrist felt {:.0f} N", detail_, felt_contact(0));
    if (gives_up || step_ == Step::kRetreat) return finish(false, why);
    return give_up(why);
  }
  advance(status);
}

bool ArmCycle::reacts_to_contact() const {
  return step_ == Step::kPlace || (options_.reacts && step_ == Step::kApproach);
}

// What is predicted to be held counts double, as its mass is a guess.
double ArmCycle::held_collision_force() const {
  return options_.collision_force +
         std::max(2 * geometry::kGravity * grasp().lifted_mass, holding_.weight().value_or(0));
}

// To the next step, as this one has ended by `status` or waits.
void ArmCycle::advance(MotionStatus status) {
  switch (step_) {
    case Step::kOpen:
      begin_segment("reach", Step::kReach, options_.collision_force);
      return;
    case Step::kReach:
      return enter(Step::kRest, "reading the wrist at rest");
    case Step::kRest:
      holding_.feel_free(percepts_.wrist_force);
      if (spent() < options_.rest_time) return;
      begin_segment("approach", Step::kApproach,
                    options_.reacts ? options_.contact_force : options_.collision_force);
      return;
    case Step::kApproach:
      return after_approach(status);
    case Step::kGather:
      return close();
    case Step::kClose:
      return after_closing(status);
    case Step::kSettle:
      if (spent() < options_.settle_time) return;
      if (const auto now = closure()) {
        const double sent = grasp().hand.closure(grasp().hand.at(options_.overrun));
        holding_.grip(now, sent - *now);
      }
      begin_segment("lift", Step::kLift, held_collision_force());
      return;
    case Step::kLift:
      holding_.begin_weighing();
      return enter(Step::kCheck, "weighing what is held");
    case Step::kCheck:
      holding_.weigh(percepts_.wrist_force);
      if (spent() < options_.check_time) return;
      return check();
    case Step::kCarry: {
      // What reacts to contact lowers the object until something bears it.
      const double weight = holding_.weight().value_or(0);
      begin_segment("place", Step::kPlace,
                    options_.reacts ? weight + options_.contact_force : held_collision_force());
      return;
    }
    case Step::kPlace:
      return after_placing(status);
    case Step::kRelease:
      begin_segment("retreat", Step::kRetreat, options_.collision_force);
      return;
    case Step::kRetreat:
      holding_.begin_weighing();
      return enter(Step::kVerify, "looking whether the hand is empty");
    case Step::kVerify:
      holding_.weigh(percepts_.wrist_force);
      if (spent() < options_.check_time) return;
      return verify();
    case Step::kGiveUpOpen:
    case Step::kGoBack:
      return go_back();
    case Step::kLook:
      if (spent() > options_.look_timeout) next_grasp("no new plan came");
      return;
    case Step::kWaiting:
    case Step::kDone:
    case Step::kFailed:
      return;
  }
}

void ArmCycle::abort(const std::string& reason) {
  if (finished()) return;
  arm_.stop();
  hand_.stop();
  finish(false, reason);
}

void ArmCycle::finish(bool success, const std::string& reason) {
  result_.success = success;
  result_.reason = reason;
  enter(success ? Step::kDone : Step::kFailed, reason);
}

}  // namespace prehend::control
