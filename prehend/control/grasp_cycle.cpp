#include "prehend/control/grasp_cycle.h"
#include "prehend/geometry/gravity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>

namespace prehend::control {
namespace {

using geometry::RigidTransform;

using geometry::kGravity;

std::string millimetres(double metres) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f mm", metres * 1e3);
  return text.data();
}

std::string newtons(double force) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.1f N", force);
  return text.data();
}

double mean_sum(const Percepts& percepts) { return (percepts.left->sum + percepts.right->sum) / 2; }

RigidTransform shifted(const RigidTransform& X_WG, const Eigen::Vector3d& p_W) {
  RigidTransform X = X_WG;
  X.translation() += p_W;
  return X;
}

}  // namespace

GraspCycle::GraspCycle(const robot::GripperModel& gripper, const CycleOptions& options,
                       GripperPort& gripper_port, CarrierPort& carrier_port)
    : Cycle(options.tolerances),
      gripper_(gripper),
      options_(options),
      gripper_port_(gripper_port),
      carrier_port_(carrier_port),
      force_controller_(options.force) {
  options_.validate();
}

Phase GraspCycle::phase() const { return phase_of(step_); }

std::vector<GraspPose> GraspCycle::poses_of(const std::vector<grasp::Grasp>& grasps) {
  std::vector<GraspPose> poses;
  for (const grasp::Grasp& grasp : grasps) poses.push_back({grasp.X_WG, ""});
  return poses;
}

void GraspCycle::start(std::vector<grasp::Grasp> grasps, const std::string& problem) {
  grasps_ = std::move(grasps);
  order_.start(poses_of(grasps_));
  clear();
  step_ = Step::kWaiting;
  detail_ = "waiting for percepts";
  if (grasps_.empty()) finish(false, problem.empty() ? "the plan holds no grasp" : problem);
}

void GraspCycle::step(const Percepts& percepts) {
  if (finished() || grasps_.empty()) return;
  advance_to(percepts.time);
  if (percepts.gripper_error != 0 && step_ != Step::kWaiting) {
    return abort("the gripper reports error " + std::to_string(percepts.gripper_error));
  }
  if (stop_when_lost(percepts)) return;
  switch (step_) {
    case Step::kWaiting:
      step_waiting(percepts);
      break;
    case Step::kOpen:
    case Step::kRise:
    case Step::kCross:
    case Step::kPregrasp:
      step_transit(percepts);
      break;
    case Step::kApproach:
      step_approach(percepts);
      break;
    case Step::kClose:
      step_close(percepts);
      break;
    case Step::kPress:
      step_press(percepts);
      break;
    case Step::kLift:
      step_lift(percepts);
      break;
    case Step::kCheck:
      step_check(percepts);
      break;
    case Step::kMove:
    case Step::kLower:
      step_carry(percepts);
      break;
    case Step::kRelease:
    case Step::kRetreat:
      step_release(percepts);
      break;
    case Step::kGiveUpOpen:
    case Step::kGiveUpRetreat:
      step_give_up(percepts);
      break;
    case Step::kGiveUpRise:
    case Step::kGiveUpClear:
    case Step::kLook:
      step_look();
      break;
    case Step::kDone:
    case Step::kFailed:
      break;
  }
}

void GraspCycle::abort(const std::string& reason) {
  if (finished()) return;
  gripper_port_.stop();
  carrier_port_.stop();
  finish(false, reason);
}

void GraspCycle::enter(Step step, const std::string& detail) {
  step_ = step;
  entered(detail);
}

void GraspCycle::finish(bool success, const std::string& reason) {
  result_.success = success;
  result_.reason = reason;
  enter(success ? Step::kDone : Step::kFailed, reason);
}

void GraspCycle::move_carrier(const RigidTransform& X_WG, double speed, double contact_force) {
  X_WG_target_ = X_WG;
  carrier_port_.move_to(X_WG, speed, contact_force);
}

RigidTransform GraspCycle::pregrasp() const {
  const auto& grasp = current_grasp();
  return shifted(grasp.X_WG, -grasp.pregrasp_distance * grasp.approach_W);
}

RigidTransform GraspCycle::raised_to_transit(const RigidTransform& X_WG) const {
  const double rise = options_.transit_height - options_.up_W.dot(X_WG.translation());
  return shifted(X_WG, std::max(0.0, rise) * options_.up_W);
}

void GraspCycle::begin_grasp(int index) {
  watch_.begin(now());
  begin_attempt(index);
  order_.begin(index);
  gripper_port_.move_to(std::min(current_grasp().pregrasp_opening, gripper_.max_opening),
                        options_.opening_speed);
  enter(Step::kOpen, "opening to " + millimetres(current_grasp().pregrasp_opening));
}

void GraspCycle::step_transit(const Percepts& percepts) {
  const bool opening = step_ == Step::kOpen;
  const MotionStatus status = opening ? gripper_port_.motion() : carrier_port_.motion();
  if (status == MotionStatus::kFailed || status == MotionStatus::kContact) {
    return give_up_attempt(opening ? "the gripper does not open"
                                   : "the carrier does not reach the pregrasp");
  }
  if (status == MotionStatus::kMoving) {
    if (timed_out(options_.motion_timeout)) {
      give_up_attempt(opening ? "opening the gripper timed out"
                              : "the way to the pregrasp timed out");
    }
    return;
  }
  switch (step_) {
    case Step::kOpen:
      enter(Step::kRise, "rising to the transit height");
      move_carrier(raised_to_transit(percepts.X_WG.value_or(X_WG_target_)), options_.travel_speed,
                   0);
      break;
    case Step::kRise:
      enter(Step::kCross, "crossing to above the pregrasp");
      move_carrier(raised_to_transit(pregrasp()), options_.travel_speed, 0);
      break;
    case Step::kCross:
      enter(Step::kPregrasp, "going to the pregrasp");
      move_carrier(pregrasp(), options_.travel_speed, 0);
      break;
    default:
      enter(Step::kApproach, "approaching");
      move_carrier(current_grasp().X_WG, options_.approach_speed, options_.contact_force);
      break;
  }
}

void GraspCycle::step_approach(const Percepts& percepts) {
  const bool pads_touched = std::max(percepts.left->sum, percepts.right->sum) >
                            std::max(options_.touch_force, options_.contact_force);
  const MotionStatus status = carrier_port_.motion();
  if (status == MotionStatus::kContact || pads_touched) {
    const double felt = pads_touched ? std::max(percepts.left->sum, percepts.right->sum)
                                     : percepts.wrist_force.value_or(options_.contact_force);
    surprises_.push_back(
        {SurpriseKind::kTouchedTooEarly, 0, felt, 0, true, "back off, take the next grasp"});
    return give_up_attempt("touched something on the approach");
  }
  if (status == MotionStatus::kFailed) return give_up_attempt("the approach failed");
  if (status == MotionStatus::kMoving) {
    if (timed_out(options_.motion_timeout)) give_up_attempt("the approach timed out");
    return;
  }
  enter(Step::kClose, "closing until both pads touch");
}

void GraspCycle::step_close(const Percepts& percepts) {
  const bool left = percepts.left->sum > options_.touch_force;
  const bool right = percepts.right->sum > options_.touch_force;
  if (left && right) {
    const auto& predicted = current_grasp().predicted;
    add_surprise(SurpriseKind::kOpeningAtContact, predicted.opening, *percepts.opening,
                 "grip what is there");
    force_controller_.start(current_grasp().grasp_force, mean_sum(percepts));
    last_update_ = now();
    settled_since_ = -1;
    return enter(Step::kPress, "both pads touch at " + millimetres(*percepts.opening) +
                                   ", rising to " + newtons(current_grasp().grasp_force));
  }
  const std::string felt =
      left || right ? std::string("only the ") + (left ? "left" : "right") + " pad felt something"
                    : "neither pad felt anything";
  // Blocked at once means the drive has not broken away yet.
  if (percepts.gripper_blocked && spent() > 0.5) {
    return give_up_attempt("closing was blocked, " + felt);
  }
  if (*percepts.opening < 1e-3) return give_up_attempt("closed completely, " + felt);
  if (timed_out(options_.closing_timeout)) return give_up_attempt("closing timed out, " + felt);
  // Enough to break the drive away and push the object to the middle, not more than the grasp.
  const double current =
      std::clamp((gripper_.friction_force + std::max(5.0, current_grasp().grasp_force / 2)) /
                     gripper_.force_per_current,
                 options_.force.least_current, options_.force.largest_current);
  // Faster through what should be empty.
  const bool far = !left && !right &&
                   *percepts.opening > current_grasp().predicted.opening + options_.closing_margin;
  gripper_port_.command_velocity(-(far ? options_.fast_closing_speed : options_.closing_speed),
                                 current);
}

void GraspCycle::regulate_force(const Percepts& percepts) {
  const double dt = now() - last_update_;
  last_update_ = now();
  const double current = force_controller_.update(mean_sum(percepts), dt);
  gripper_port_.command_velocity(-options_.pressing_speed, current);
}

void GraspCycle::step_press(const Percepts& percepts) {
  regulate_force(percepts);
  if (!force_controller_.settled()) settled_since_ = -1;
  if (force_controller_.settled() && settled_since_ < 0) settled_since_ = now();
  if (*percepts.opening < 1e-3) return give_up_attempt("the object slipped out while gripping");
  if (settled_since_ < 0 || now() - settled_since_ < options_.settled_time) {
    if (!timed_out(options_.force_timeout)) return;
    // Dry friction of the drive can hold more than was asked for: that is no reason to let go.
    const double felt = mean_sum(percepts), wanted = current_grasp().grasp_force;
    if (felt < options_.least_share * wanted || felt > options_.largest_excess * wanted) {
      return give_up_attempt("the grasp force was not reached: " + newtons(felt) + " of " +
                             newtons(wanted));
    }
  }
  const auto& predicted = current_grasp().predicted;
  add_surprise(SurpriseKind::kContactArea, predicted.contact_area,
               (percepts.left->area + percepts.right->area) / 2,
               "grip anyhow, look after the lift");
  add_surprise(SurpriseKind::kTactileSum, predicted.tactile_sum, mean_sum(percepts),
               "grip anyhow, look after the lift");
  grasp_opening_ = *percepts.opening;
  enter(Step::kLift, "lifting by " + millimetres(options_.lift_height));
  move_carrier(shifted(current_grasp().X_WG, options_.lift_height * options_.up_W),
               options_.lift_speed, 0);
}

std::string GraspCycle::why_not_held(const Percepts& percepts) const {
  const double least =
      std::max(options_.touch_force, options_.held_ratio * current_grasp().grasp_force);
  if (*percepts.opening < grasp_opening_ - options_.largest_collapse) {
    return "the opening collapsed from " + millimetres(grasp_opening_) + " to " +
           millimetres(*percepts.opening);
  }
  for (const auto& [name, pad] :
       {std::pair{"left", percepts.left}, std::pair{"right", percepts.right}}) {
    if (pad->sum < least) {
      return std::string("the ") + name + " pad feels only " + newtons(pad->sum);
    }
  }
  return "";
}

void GraspCycle::step_lift(const Percepts& percepts) {
  regulate_force(percepts);
  const MotionStatus status = carrier_port_.motion();
  if (status == MotionStatus::kReached) return enter(Step::kCheck, "looking whether it is held");
  if (status != MotionStatus::kMoving) return give_up_attempt("the lift failed");
  if (timed_out(options_.motion_timeout)) give_up_attempt("the lift timed out");
}

void GraspCycle::step_check(const Percepts& percepts) {
  regulate_force(percepts);
  if (spent() < options_.check_time) return;
  const std::string reason = why_not_held(percepts);
  add_surprise(SurpriseKind::kHeldAfterLift, 1, reason.empty() ? 1 : 0, "take the next grasp");
  if (!reason.empty()) return give_up_attempt("not held after the lift: " + reason);
  enter(Step::kMove, "carrying it sideways");
  move_carrier(
      shifted(current_grasp().X_WG, options_.lift_height * options_.up_W + options_.move_W),
      options_.travel_speed, 0);
}

void GraspCycle::step_carry(const Percepts& percepts) {
  regulate_force(percepts);
  const bool lowering = step_ == Step::kLower;
  const std::string reason = why_not_held(percepts);
  // On the table it leans on one pad more than on the other, but it stays between them.
  const bool collapsed = *percepts.opening < grasp_opening_ - options_.largest_collapse;
  if (lowering ? collapsed : !reason.empty()) {
    add_surprise(SurpriseKind::kHeldWhileCarried, 1, 0, "take the next grasp");
    return give_up_attempt((lowering ? "lost while lowering: " : "lost while carrying: ") + reason);
  }
  const MotionStatus status = carrier_port_.motion();
  if (status == MotionStatus::kFailed || (status == MotionStatus::kContact && !lowering)) {
    return give_up_attempt("the carrier failed while carrying");
  }
  if (status == MotionStatus::kMoving) {
    if (timed_out(options_.motion_timeout)) give_up_attempt("carrying timed out");
    return;
  }
  if (!lowering) {
    enter(Step::kLower, "lowering it");
    const double weight = kGravity * current_grasp().predicted.lifted_mass;
    return move_carrier(shifted(current_grasp().X_WG, options_.move_W), options_.approach_speed,
                        weight + options_.contact_force);
  }
  enter(Step::kRelease, "opening");
  gripper_port_.move_to(gripper_.max_opening, options_.opening_speed);
}

void GraspCycle::step_release(const Percepts& percepts) {
  const bool opening = step_ == Step::kRelease;
  const MotionStatus status = opening ? gripper_port_.motion() : carrier_port_.motion();
  if (status == MotionStatus::kMoving && !timed_out(options_.motion_timeout)) return;
  if (status != MotionStatus::kReached) {
    return abort(opening ? "the gripper does not open to release the object"
                         : "the carrier does not retreat");
  }
  if (opening) {
    enter(Step::kRetreat, "retreating");
    const RigidTransform X_WG = percepts.X_WG.value_or(X_WG_target_);
    return move_carrier(
        shifted(X_WG, -current_grasp().pregrasp_distance * current_grasp().approach_W),
        options_.travel_speed, 0);
  }
  const double left = percepts.left ? percepts.left->sum : 0;
  const double right = percepts.right ? percepts.right->sum : 0;
  const bool empty = std::max(left, right) <= options_.touch_force;
  add_surprise(SurpriseKind::kPlaced, 1, empty ? 1 : 0, "end");
  if (!empty) {
    return finish(false, "what was to be put down did not leave the hand: the pads still feel " +
                             newtons(left) + " and " + newtons(right));
  }
  finish(true, "gripped with " + newtons(force_controller_.target()) + " at an opening of " +
                   millimetres(grasp_opening_) + ", lifted by " +
                   millimetres(options_.lift_height) + ", carried by " +
                   millimetres(options_.move_W.norm()) + ", put down and released");
}

void GraspCycle::give_up_attempt(const std::string& reason) {
  fail_attempt(static_cast<int>(step_), reason,
               step_ == Step::kClose ? SurpriseKind::kFingersTouch : SurpriseKind::kMotion,
               "take the next grasp");
  carrier_port_.stop();
  gripper_port_.stop();
  gripper_port_.move_to(gripper_.max_opening, options_.opening_speed);
  enter(Step::kGiveUpOpen, reason + "; opening");
}

void GraspCycle::step_give_up(const Percepts& percepts) {
  const bool opening = step_ == Step::kGiveUpOpen;
  const MotionStatus status = opening ? gripper_port_.motion() : carrier_port_.motion();
  if (status == MotionStatus::kMoving && !timed_out(options_.motion_timeout)) return;
  if (opening) {
    // Blocked fingers are no reason to stay: back off along the approach.
    enter(Step::kGiveUpRetreat, failure() + "; retreating");
    const RigidTransform X_WG = percepts.X_WG.value_or(X_WG_target_);
    return move_carrier(
        shifted(X_WG, -current_grasp().pregrasp_distance * current_grasp().approach_W),
        options_.travel_speed, 0);
  }
  if (status != MotionStatus::kReached) {
    return abort(failure() + "; then the carrier does not retreat");
  }
  order_.fail(grasp_index());
  if (options_.look_timeout > 0 && result_.attempts < options_.largest_attempts) {
    enter(Step::kGiveUpRise, failure() + "; getting out of the camera's view");
    return move_carrier(raised_to_transit(percepts.X_WG.value_or(X_WG_target_)),
                        options_.travel_speed, 0);
  }
  next_grasp("");
}

}  // namespace prehend::control
