#include "prehend/control/grasp_cycle.h"
#include "prehend/geometry/gravity.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

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

std::vector<GraspPose> poses_of(const std::vector<grasp::Grasp>& grasps) {
  std::vector<GraspPose> poses;
  for (const grasp::Grasp& grasp : grasps) poses.push_back({grasp.X_WG, ""});
  return poses;
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
    : Cycle(options),
      gripper_(gripper),
      options_(options),
      gripper_port_(gripper_port),
      carrier_port_(carrier_port),
      force_controller_(options.force) {
  options_.validate();
}

void GraspCycle::start(std::vector<grasp::Grasp> grasps, const std::string& problem) {
  grasps_ = std::move(grasps);
  detail_ = "waiting for percepts";
  start_task(poses_of(grasps_), problem);
}

void GraspCycle::take_plan(std::vector<grasp::Grasp> grasps, const Eigen::Vector3d& move_W,
                           const std::string& problem) {
  if (!waits_for_plan()) return;
  std::vector<GraspPose> poses = poses_of(grasps);
  if (!grasps.empty()) {
    grasps_ = std::move(grasps);
    options_.move_W = move_W;
  }
  plan_taken(std::move(poses), problem);
}

void GraspCycle::step(const Percepts& percepts) {
  if (finished() || grasps_.empty()) return;
  advance_to(percepts.time);
  percepts_ = percepts;
  if (waits_for_inputs()) return step_waiting();
  if (percepts.gripper_error != 0) {
    return abort("the gripper reports error " + std::to_string(percepts.gripper_error));
  }
  if (waits_for_plan()) return step_look();
  if (stop_when_lost()) return;
  switch (step_) {
    case Step::kOpen:
    case Step::kRise:
    case Step::kCross:
    case Step::kPregrasp:
      return step_transit();
    case Step::kApproach:
      return step_approach();
    case Step::kClose:
      return step_close();
    case Step::kPress:
      return step_press();
    case Step::kLift:
      return step_lift();
    case Step::kCheck:
      return step_check();
    case Step::kCarry:
    case Step::kLower:
      return step_carry();
    case Step::kRelease:
    case Step::kRetreat:
      return step_release();
    case Step::kRiseClear:
    case Step::kClear:
      return step_clear();
    case Step::kWait:
      if (holds_) regulate_force();
      if (spent() >= wait_time_) ended(Outcome::kDone);
      return;
  }
}

void GraspCycle::stop_motion() {
  carrier_port_.stop();
  gripper_port_.stop();
}

void GraspCycle::enter(Step step, const std::string& detail) {
  step_ = step;
  entered(detail);
}

void GraspCycle::move_carrier(const RigidTransform& X_WG, double speed, double contact_force) {
  X_WG_target_ = X_WG;
  carrier_port_.move_to(X_WG, speed, contact_force);
}

RigidTransform GraspCycle::pregrasp() const {
  const auto& grasp = current_grasp();
  return shifted(grasp.X_WG, -grasp.pregrasp_distance * grasp.approach_W);
}

RigidTransform GraspCycle::lifted(double share) const {
  return shifted(current_grasp().X_WG, share * options_.lift_height * options_.up_W);
}

RigidTransform GraspCycle::raised_to_transit(const RigidTransform& X_WG) const {
  const double rise = options_.transit_height - options_.up_W.dot(X_WG.translation());
  return shifted(X_WG, std::max(0.0, rise) * options_.up_W);
}

void GraspCycle::prepare_attempt() {
  watch_.begin(now());
  holds_ = stands_ = false;
}

void GraspCycle::begin(const Action& action) {
  switch (action.primitive) {
    case Primitive::kLook:
      return;  // Cycle's
    case Primitive::kApproach:
    case Primitive::kTouch:
      gripper_port_.move_to(std::min(current_grasp().pregrasp_opening, gripper_.max_opening),
                            options_.opening_speed);
      return enter(Step::kOpen, "opening to " + millimetres(current_grasp().pregrasp_opening));
    case Primitive::kGrasp:
      return enter(Step::kClose, "closing until both pads touch");
    case Primitive::kLift:
      enter(Step::kLift, "lifting by " + millimetres(options_.lift_height));
      return move_carrier(lifted(), options_.lift_speed, 0);
    case Primitive::kMove:
      return begin_move(action);
    case Primitive::kPlace: {
      enter(Step::kLower, "lowering it");
      const double weight = kGravity * current_grasp().predicted.lifted_mass;
      return move_carrier(shifted(current_grasp().X_WG, options_.move_W), options_.approach_speed,
                          weight + options_.contact_force);
    }
    case Primitive::kRelease:
      holds_ = false;
      gripper_port_.move_to(gripper_.max_opening, options_.opening_speed);
      return enter(Step::kRelease, failure().empty() ? "opening" : failure() + "; opening");
    case Primitive::kRetreat:
      enter(Step::kRetreat, failure().empty() ? "retreating" : failure() + "; retreating");
      return move_carrier(shifted(percepts_.X_WG.value_or(X_WG_target_),
                                  -current_grasp().pregrasp_distance * current_grasp().approach_W),
                          options_.travel_speed, 0);
    case Primitive::kWait:
      wait_time_ = action.seconds;
      return enter(Step::kWait, fmt::format("waiting for {:.3g} s", action.seconds));
  }
}

void GraspCycle::begin_move(const Action& action) {
  using Goal = Action::Goal;
  const bool down = action.goal == Goal::kLowered && action.share >= 1;
  if (down) {
    enter(Step::kLower, "lowering it");
    const double weight = kGravity * current_grasp().predicted.lifted_mass;
    return move_carrier(current_grasp().X_WG, options_.approach_speed,
                        weight + options_.contact_force);
  }
  const bool sideways = action.goal == Goal::kPlace;
  enter(Step::kCarry, sideways                       ? "carrying it sideways"
                      : action.goal == Goal::kLifted ? "lifting it again"
                                                     : "lowering it in part");
  const RigidTransform X_WG = action.goal == Goal::kLowered ? lifted(1 - action.share) : lifted();
  move_carrier(sideways ? shifted(X_WG, options_.move_W) : X_WG, options_.travel_speed, 0);
}

void GraspCycle::step_transit() {
  const bool opening = step_ == Step::kOpen;
  const MotionStatus status = opening ? gripper_port_.motion() : carrier_port_.motion();
  if (status == MotionStatus::kFailed || status == MotionStatus::kContact) {
    return give_up(opening ? "the gripper does not open"
                           : "the carrier does not reach the pregrasp");
  }
  if (status == MotionStatus::kMoving) {
    if (timed_out(options_.motion_timeout)) {
      give_up(opening ? "opening the gripper timed out" : "the way to the pregrasp timed out");
    }
    return;
  }
  switch (step_) {
    case Step::kOpen:
      enter(Step::kRise, "rising to the transit height");
      return move_carrier(raised_to_transit(percepts_.X_WG.value_or(X_WG_target_)),
                          options_.travel_speed, 0);
    case Step::kRise:
      enter(Step::kCross, "crossing to above the pregrasp");
      return move_carrier(raised_to_transit(pregrasp()), options_.travel_speed, 0);
    case Step::kCross:
      enter(Step::kPregrasp, "going to the pregrasp");
      return move_carrier(pregrasp(), options_.travel_speed, 0);
    default:
      enter(Step::kApproach, "approaching");
      return move_carrier(current_grasp().X_WG, options_.approach_speed, options_.contact_force);
  }
}

void GraspCycle::step_approach() {
  const bool pads_touched = std::max(percepts_.left->sum, percepts_.right->sum) >
                            std::max(options_.touch_force, options_.contact_force);
  const MotionStatus status = carrier_port_.motion();
  const bool touches = primitive() == Primitive::kTouch;
  if (status == MotionStatus::kContact || pads_touched) {
    if (touches) {
      carrier_port_.stop();
      return ended(Outcome::kDone);
    }
    const double felt = pads_touched ? std::max(percepts_.left->sum, percepts_.right->sum)
                                     : percepts_.wrist_force.value_or(options_.contact_force);
    add_surprise({SurpriseKind::kTouchedTooEarly, 0, felt, 0, true, "lets go and looks again"});
    return give_up("touched something on the approach");
  }
  if (status == MotionStatus::kFailed) return give_up("the approach failed");
  if (status == MotionStatus::kMoving) {
    if (timed_out(options_.motion_timeout)) give_up("the approach timed out");
    return;
  }
  ended(touches ? Outcome::kNothing : Outcome::kDone, touches ? "nothing was met" : "");
}

void GraspCycle::step_close() {
  const auto give_up_closing = [this](const std::string& why) {
    give_up(why, SurpriseKind::kFingersTouch);
  };
  const bool left = percepts_.left->sum > options_.touch_force;
  const bool right = percepts_.right->sum > options_.touch_force;
  if (left && right) {
    const auto& predicted = current_grasp().predicted;
    add_surprise(SurpriseKind::kOpeningAtContact, predicted.opening, *percepts_.opening,
                 "grip what is there");
    force_controller_.start(current_grasp().grasp_force, mean_sum(percepts_));
    last_update_ = now();
    settled_since_ = -1;
    return enter(Step::kPress, "both pads touch at " + millimetres(*percepts_.opening) +
                                   ", rising to " + newtons(current_grasp().grasp_force));
  }
  const std::string felt =
      left || right ? std::string("only the ") + (left ? "left" : "right") + " pad felt something"
                    : "neither pad felt anything";
  // Blocked at once means the drive has not broken away yet.
  if (percepts_.gripper_blocked && spent() > 0.5) {
    return give_up_closing("closing was blocked, " + felt);
  }
  if (*percepts_.opening < 1e-3) return give_up_closing("closed completely, " + felt);
  if (timed_out(options_.closing_timeout)) return give_up_closing("closing timed out, " + felt);
  // Enough to break the drive away and push the object to the middle, not more than the grasp.
  const double current =
      std::clamp((gripper_.friction_force + std::max(5.0, current_grasp().grasp_force / 2)) /
                     gripper_.force_per_current,
                 options_.force.least_current, options_.force.largest_current);
  // Faster through what should be empty.
  const bool far = !left && !right &&
                   *percepts_.opening > current_grasp().predicted.opening + options_.closing_margin;
  gripper_port_.command_velocity(-(far ? options_.fast_closing_speed : options_.closing_speed),
                                 current);
}

void GraspCycle::regulate_force() {
  const double dt = now() - last_update_;
  last_update_ = now();
  const double current = force_controller_.update(mean_sum(percepts_), dt);
  gripper_port_.command_velocity(-options_.pressing_speed, current);
}

void GraspCycle::step_press() {
  regulate_force();
  if (!force_controller_.settled()) settled_since_ = -1;
  if (force_controller_.settled() && settled_since_ < 0) settled_since_ = now();
  if (*percepts_.opening < 1e-3) return give_up("the object slipped out while gripping");
  if (settled_since_ < 0 || now() - settled_since_ < options_.settled_time) {
    if (!timed_out(options_.force_timeout)) return;
    // Dry friction of the drive can hold more than was asked for: that is no reason to let go.
    const double felt = mean_sum(percepts_), wanted = current_grasp().grasp_force;
    if (felt < options_.least_share * wanted || felt > options_.largest_excess * wanted) {
      return give_up("the grasp force was not reached: " + newtons(felt) + " of " +
                     newtons(wanted));
    }
  }
  const auto& predicted = current_grasp().predicted;
  add_surprise(SurpriseKind::kContactArea, predicted.contact_area,
               (percepts_.left->area + percepts_.right->area) / 2,
               "grip anyhow, look after the lift");
  add_surprise(SurpriseKind::kTactileSum, predicted.tactile_sum, mean_sum(percepts_),
               "grip anyhow, look after the lift");
  grasp_opening_ = *percepts_.opening;
  holds_ = true;
  ended(Outcome::kDone);
}

std::string GraspCycle::why_not_held() const {
  const double least =
      std::max(options_.touch_force, options_.held_ratio * current_grasp().grasp_force);
  if (*percepts_.opening < grasp_opening_ - options_.largest_collapse) {
    return "the opening collapsed from " + millimetres(grasp_opening_) + " to " +
           millimetres(*percepts_.opening);
  }
  for (const auto& [name, pad] :
       {std::pair{"left", percepts_.left}, std::pair{"right", percepts_.right}}) {
    if (pad->sum < least) {
      return std::string("the ") + name + " pad feels only " + newtons(pad->sum);
    }
  }
  return "";
}

void GraspCycle::step_lift() {
  regulate_force();
  const MotionStatus status = carrier_port_.motion();
  if (status == MotionStatus::kReached) return enter(Step::kCheck, "looking whether it is held");
  if (status != MotionStatus::kMoving) return give_up("the lift failed");
  if (timed_out(options_.motion_timeout)) give_up("the lift timed out");
}

void GraspCycle::step_check() {
  regulate_force();
  if (spent() < options_.check_time) return;
  const std::string reason = why_not_held();
  add_surprise(SurpriseKind::kHeldAfterLift, 1, reason.empty() ? 1 : 0, "lets go and looks again");
  if (!reason.empty()) {
    return give_up("not held after the lift: " + reason, SurpriseKind::kMotion, Outcome::kLost);
  }
  achieved("gripped with " + newtons(force_controller_.target()) + " at an opening of " +
           millimetres(grasp_opening_) + ", lifted by " + millimetres(options_.lift_height));
  ended(Outcome::kDone);
}

void GraspCycle::step_carry() {
  regulate_force();
  const bool lowering = step_ == Step::kLower;
  const std::string reason = why_not_held();
  // On the table it leans on one pad more than on the other, but it stays between them.
  const bool collapsed = *percepts_.opening < grasp_opening_ - options_.largest_collapse;
  if (lowering ? collapsed : !reason.empty()) {
    add_surprise(SurpriseKind::kHeldWhileCarried, 1, 0, "lets go and looks again");
    return give_up((lowering ? "lost while lowering: " : "lost while carrying: ") + reason,
                   SurpriseKind::kMotion, Outcome::kLost);
  }
  const MotionStatus status = carrier_port_.motion();
  if (status == MotionStatus::kFailed || (status == MotionStatus::kContact && !lowering)) {
    return give_up("the carrier failed while carrying");
  }
  if (status == MotionStatus::kMoving) {
    if (timed_out(options_.motion_timeout)) give_up("carrying timed out");
    return;
  }
  stands_ = lowering;
  ended(Outcome::kDone);
}

void GraspCycle::step_release() {
  const bool opening = step_ == Step::kRelease;
  const MotionStatus status = opening ? gripper_port_.motion() : carrier_port_.motion();
  if (status == MotionStatus::kMoving && !timed_out(options_.motion_timeout)) return;
  if (status != MotionStatus::kReached) {
    stop_motion();
    return ended(Outcome::kFailed, opening ? "the gripper does not open to release the object"
                                           : "the carrier does not retreat");
  }
  if (opening || !stands_ || !failure().empty()) return ended(Outcome::kDone);
  const double left = percepts_.left ? percepts_.left->sum : 0;
  const double right = percepts_.right ? percepts_.right->sum : 0;
  const bool empty = std::max(left, right) <= options_.touch_force;
  add_surprise(SurpriseKind::kPlaced, 1, empty ? 1 : 0, "end");
  if (!empty) {
    return ended(Outcome::kFailed,
                 "what was to be put down did not leave the hand: the pads still feel " +
                     newtons(left) + " and " + newtons(right));
  }
  achieved("gripped with " + newtons(force_controller_.target()) + " at an opening of " +
           millimetres(grasp_opening_) + ", lifted by " + millimetres(options_.lift_height) +
           (is_at_place() ? ", carried by " + millimetres(options_.move_W.norm()) : "") +
           ", put down and released");
  ended(Outcome::kDone);
}

}  // namespace prehend::control
