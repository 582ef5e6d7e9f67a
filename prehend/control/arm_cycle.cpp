#include "prehend/control/arm_cycle.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/geometry/gravity.h"
#include "prehend/text/require.h"

namespace prehend::control {
namespace {

using geometry::kGravity;

}  // namespace

void ArmCycleOptions::validate() const {
  const text::Require require{"ArmCycleOptions."};
  require(std::isfinite(contact_force) && contact_force > 0, "contact_force must be positive");
  require(opening_speed > 0 && opening_speed <= 1, "opening_speed must be in (0, 1]");
  require(closing_speed > 0 && closing_speed <= 1, "closing_speed must be in (0, 1]");
  require(std::isfinite(overrun) && overrun >= 0, "overrun must not be negative");
  require(std::isfinite(gather) && gather >= 0, "gather must not be negative");
  require(std::isfinite(settle_time) && settle_time >= 0, "settle_time must not be negative");
  require(std::isfinite(check_time) && check_time >= 0, "check_time must not be negative");
  require(held_ratio >= 0 && held_ratio < 1, "held_ratio must be in [0, 1)");
  require(std::isfinite(least_weight) && least_weight > 0, "least_weight must be positive");
  require(std::isfinite(motion_timeout) && motion_timeout > 0, "motion_timeout must be positive");
  require(std::isfinite(largest_detour) && largest_detour > 0, "largest_detour must be positive");
  require(largest_attempts > 0, "largest_attempts must be positive");
  require(std::isfinite(stale_time) && stale_time > 0, "stale_time must be positive");
  require(std::isfinite(answer_time) && answer_time > 0, "answer_time must be positive");
  require(std::isfinite(look_timeout) && look_timeout >= 0, "look_timeout must not be negative");
}

JointPath reversed(const JointPath& path) {
  JointPath back = path;
  std::reverse(back.points.begin(), back.points.end());
  const double duration = path.points.empty() ? 0.0 : path.points.back().time;
  for (JointPath::Point& point : back.points) {
    point.time = duration - point.time;
    for (double& v : point.velocity) v = -v;
  }
  return back;
}

JointPath joined(JointPath path, const std::vector<std::string>& names,
                 const std::vector<double>& positions, double most) {
  if (path.points.empty()) throw std::invalid_argument("the arm's segment has no points");
  const double duration = path.points.back().time;
  for (std::size_t k = 0; k < path.joints.size(); ++k) {
    const auto found = std::find(names.begin(), names.end(), path.joints[k]);
    if (found == names.end()) {
      throw std::invalid_argument("no joint '" + path.joints[k] + "' tells where it stands");
    }
    if (path.points.front().position.size() != path.joints.size()) {
      throw std::invalid_argument("the arm's segment has not one position a joint");
    }
    const double off = positions.at(static_cast<std::size_t>(found - names.begin())) -
                       path.points.front().position[k];
    if (!(std::abs(off) <= most)) {
      throw std::invalid_argument(fmt::format(
          "joint '{}' stands {:.2f} rad from where the plan begins", path.joints[k], off));
    }
    if (off == 0 || duration <= 0) continue;
    for (JointPath::Point& point : path.points) {
      if (point.position.size() != path.joints.size()) {
        throw std::invalid_argument("the arm's segment has not one position a joint");
      }
      const double s = point.time / duration;
      point.position[k] += off * (1 - s * s * s * (10 + s * (6 * s - 15)));
      if (k < point.velocity.size()) {
        point.velocity[k] -= off * 30 * s * s * (1 - s) * (1 - s) / duration;
      }
      if (k < point.acceleration.size()) {
        point.acceleration[k] -= off * 60 * s * (1 - s) * (1 - 2 * s) / (duration * duration);
      }
    }
  }
  return path;
}

ArmCycle::ArmCycle(const ArmCycleOptions& options, ArmPort& arm, HandPort& hand)
    : options_(options), arm_(arm), hand_(hand) {
  options.validate();
}

Phase ArmCycle::phase_of(Step step) {
  switch (step) {
    case Step::kWaiting:
    case Step::kLook:
      return Phase::kWaiting;
    case Step::kOpen:
    case Step::kReach:
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
  const std::string name = to_string(phase_of(step));
  if (phase_times_.empty() || phase_times_.back().first != name) phase_times_.emplace_back(name, 0);
  step_ = step;
  detail_ = detail;
  step_start_ = now_.time;
}

void ArmCycle::start(std::vector<ArmGrasp> grasps, const std::string& problem) {
  grasps_ = std::move(grasps);
  result_ = {};
  surprises_.clear();
  phase_times_.clear();
  failed_attempts_.clear();
  grasp_index_ = 0;
  step_ = Step::kWaiting;
  if (grasps_.empty()) return finish(false, problem.empty() ? "the plan has no grasps" : problem);
  step_start_ = now_.time;
  step_waiting();
}

std::vector<InputAge> ArmCycle::inputs() {
  const auto age = [](bool has_come, double seconds) {
    return has_come ? std::optional(seconds) : std::nullopt;
  };
  return {
      {"the joints' states", age(!now_.names.empty(), now_.joints_age), options_.stale_time},
      {"the wrist's force", age(now_.wrist_force.has_value(), now_.wrist_age), options_.stale_time},
      {"the server of the arm's motion", arm_.answer_age(), options_.answer_time},
      {"the server of the hand's motion", hand_.answer_age(), options_.answer_time}};
}

void ArmCycle::step_waiting() {
  if (grasps_.empty()) return;  // not started
  const std::vector<InputAge> missing = stale_inputs(inputs());
  if (missing.empty()) return begin_attempt();
  detail_ = "waiting for " + names_of(missing);
  if (now_.time - step_start_ > options_.motion_timeout) {
    finish(false, "nothing was moved, for want of " + describe(missing));
  }
}

bool ArmCycle::stop_when_lost() {
  if (step_ == Step::kLook) return false;
  const std::vector<InputAge> lost = watch_.lost(now_.time, inputs());
  if (lost.empty()) return false;
  abort("lost " + describe(lost) + " while " + detail_ + "; arm and hand were stopped");
  return true;
}

void ArmCycle::begin_attempt() {
  watch_.begin(now_.time);
  ++result_.attempts;
  result_.grasp_index = grasp_index_;
  failure_.clear();
  gone_.clear();
  hand_.move(grasp().hand_joints, grasp().open, options_.opening_speed, false);
  enter(Step::kOpen, fmt::format("grasp {}: opening the hand", grasp_index_));
}

void ArmCycle::follow(const JointPath& path, double contact_force) {
  refused_.clear();
  try {
    const JointPath from_here = joined(path, now_.names, now_.positions, options_.largest_detour);
    gone_.push_back(from_here);
    arm_.follow(from_here, contact_force);
  } catch (const std::invalid_argument& error) {
    refused_ = error.what();
  }
}

bool ArmCycle::begin_segment(const std::string& name, Step step, double contact_force) {
  enter(step, "arm: " + name);
  for (const auto& [segment, path] : grasp().segments) {
    if (segment != name) continue;
    follow(path, contact_force);
    return true;
  }
  return false;
}

void ArmCycle::gather() {
  if (options_.gather == 0) return close();
  std::vector<double> before = grasp().closed;
  for (std::size_t i = 0; i < before.size(); ++i) {
    const double way = grasp().closed[i] - grasp().open[i];
    before[i] -= std::copysign(std::min(options_.gather, std::abs(way)), way);
  }
  hand_.move(grasp().hand_joints, before, options_.closing_speed, true);
  enter(Step::kGather, "gathering the fingers round the object");
}

void ArmCycle::close() {
  std::vector<double> beyond = grasp().closed;
  for (std::size_t i = 0; i < beyond.size(); ++i) {
    const double way = grasp().closed[i] - grasp().open[i];
    if (std::abs(way) > 1e-3) beyond[i] += std::copysign(options_.overrun, way);
  }
  hand_.move(grasp().hand_joints, beyond, options_.closing_speed, true);
  enter(Step::kClose, "closing the hand");
}

void ArmCycle::after_approach(MotionStatus status) {
  if (status == MotionStatus::kContact) {
    add_surprise(SurpriseKind::kTouchedTooEarly, 0, now_.wrist_force.value_or(0),
                 "closes where it touches");
  }
  gather();
}

void ArmCycle::check() {
  const double weight = grasp().lifted_mass * kGravity;
  const double least = std::max(options_.least_weight, options_.held_ratio * weight);
  const double felt = now_.wrist_force.value_or(0);
  const bool held = felt >= least;
  add_surprise(SurpriseKind::kHeldAfterLift, 1, held ? 1 : 0, "opens and tries the next grasp");
  if (!held) {
    return give_up(
        fmt::format("nothing is held after the lift: the wrist bears {:.2f} N, less "
                    "than {:.2f} N",
                    felt, least));
  }
  begin_segment("carry", Step::kCarry, 0);
}

void ArmCycle::give_up(const std::string& reason) {
  failure_ = fmt::format("grasp {}: {}", grasp_index_, reason);
  failed_attempts_.add(static_cast<int>(step_), failure_);
  arm_.stop();
  hand_.move(grasp().hand_joints, grasp().open, options_.opening_speed, false);
  enter(Step::kGiveUpOpen, failure_ + "; opening");
}

void ArmCycle::go_back() {
  if (gone_.empty()) {
    if (options_.look_timeout > 0 && result_.attempts < options_.largest_attempts) {
      return enter(Step::kLook, failure_ + "; looking again");
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
  return step_ == Step::kLook ? std::optional(step_start_) : std::nullopt;
}

void ArmCycle::take_plan(std::vector<ArmGrasp> grasps, const std::string& problem) {
  if (step_ != Step::kLook) return;
  if (grasps.empty()) {
    return next_grasp("the new look gives no grasp" + (problem.empty() ? "" : ": " + problem));
  }
  grasps_ = std::move(grasps);
  grasp_index_ = 0;
  ++result_.plans;
  begin_attempt();
}

// `why` it is not a grasp of a new look, in words; empty: nobody looked.
void ArmCycle::next_grasp(const std::string& why) {
  if (grasp_index_ + 1 >= static_cast<int>(grasps_.size()) ||
      result_.attempts >= options_.largest_attempts) {
    return finish(false, failed_attempts_.text() + (why.empty() ? "" : "; " + why));
  }
  ++grasp_index_;
  begin_attempt();
  if (!why.empty()) detail_ = why + ": the next grasp of the plan before; " + detail_;
}

void ArmCycle::step(const ArmPercepts& percepts) {
  if (!phase_times_.empty()) {
    phase_times_.back().second += std::max(0.0, percepts.time - now_.time);
  }
  now_ = percepts;
  if (finished()) return;
  if (step_ == Step::kWaiting) return step_waiting();
  if (stop_when_lost()) return;
  const double spent = now_.time - step_start_;
  const bool hand_moves = step_ == Step::kOpen || step_ == Step::kGather || step_ == Step::kClose ||
                          step_ == Step::kRelease || step_ == Step::kGiveUpOpen;
  const bool waits = step_ == Step::kSettle || step_ == Step::kCheck || step_ == Step::kLook;
  // A segment that the plan does not have ends at once.
  static const std::pair<Step, const char*> kSegments[] = {
      {Step::kReach, "reach"}, {Step::kApproach, "approach"}, {Step::kLift, "lift"},
      {Step::kCarry, "carry"}, {Step::kPlace, "place"},       {Step::kRetreat, "retreat"}};
  MotionStatus status = MotionStatus::kReached;
  if (hand_moves) {
    status = hand_.motion();
  } else if (!waits) {
    bool planned = step_ == Step::kGoBack;
    for (const auto& [step, name] : kSegments) {
      if (step != step_) continue;
      const std::string wanted = name;
      planned = std::any_of(grasp().segments.begin(), grasp().segments.end(),
                            [&](const auto& segment) { return segment.first == wanted; });
    }
    if (!refused_.empty()) {
      status = MotionStatus::kFailed;
    } else if (planned) {
      status = arm_.motion();
    }
  }
  if (!waits && status == MotionStatus::kMoving) {
    if (spent <= options_.motion_timeout) return;
    arm_.stop();
    hand_.stop();
    if (step_ == Step::kGiveUpOpen || step_ == Step::kGoBack) {
      return finish(false, failure_ + "; " + detail_ + " took too long");
    }
    return give_up(detail_ + " took too long");
  }
  if (status == MotionStatus::kFailed) {
    std::string why = detail_ + ": ";
    why += hand_moves ? hand_.problem() : (refused_.empty() ? arm_.problem() : refused_);
    if (step_ == Step::kGiveUpOpen || step_ == Step::kGoBack) {
      return finish(false, failure_ + "; " + why);
    }
    if (step_ == Step::kRetreat) return finish(false, why);
    return give_up(why);
  }
  switch (step_) {
    case Step::kOpen:
      begin_segment("reach", Step::kReach, 0);
      return;
    case Step::kReach:
      begin_segment("approach", Step::kApproach, options_.reacts ? options_.contact_force : 0);
      return;
    case Step::kApproach:
      return after_approach(status);
    case Step::kGather:
      return close();
    case Step::kClose:
      // Fingers that get to the end of their way touch nothing.
      if (status == MotionStatus::kReached) return give_up("the fingers closed on nothing");
      return enter(Step::kSettle, "pressing");
    case Step::kSettle:
      if (spent < options_.settle_time) return;
      begin_segment("lift", Step::kLift, 0);
      return;
    case Step::kLift:
      return enter(Step::kCheck, "looking whether it is held");
    case Step::kCheck:
      if (spent < options_.check_time) return;
      return check();
    case Step::kCarry:
      begin_segment("place", Step::kPlace, 0);
      return;
    case Step::kPlace:
      hand_.move(grasp().hand_joints, grasp().open, options_.opening_speed, false);
      return enter(Step::kRelease, "opening the hand");
    case Step::kRelease:
      begin_segment("retreat", Step::kRetreat, 0);
      return;
    case Step::kRetreat:
      return finish(true, fmt::format("grasp {}: lifted, held, put down", grasp_index_));
    case Step::kGiveUpOpen:
    case Step::kGoBack:
      return go_back();
    case Step::kLook:
      if (spent > options_.look_timeout) next_grasp("no new plan came");
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

void ArmCycle::add_surprise(SurpriseKind kind, double predicted, double felt,
                            const std::string& reaction) {
  surprises_.push_back(compare(kind, predicted, felt, SurpriseTolerances{}, reaction));
}

}  // namespace prehend::control
