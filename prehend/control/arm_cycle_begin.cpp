// What the primitive actions of a task begin with: the arm's segments and the hand's closing.

#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "prehend/control/arm_cycle.h"

namespace prehend::control {

using motion::SegmentKind;

void ArmCycle::prepare_attempt() {
  watch_.begin(now());
  if (is_first_try()) least_force_ = 0;
  ArmGrasp& grasp = grasps_[static_cast<std::size_t>(grasp_index())];
  if (grasp.force > 0 && grasp.force < least_force_ && !grasp.knows_slip) {
    grasp.tactile_sum *= least_force_ / grasp.force;
    grasp.contact_area = 0;  // at that force it is not predicted
    grasp.force = least_force_;
  }
  hand_.prepare(grasp);
  gone_.clear();
  clears_ = false;
  lowered_.reset();
  put_down_ = false;
  reliefs_ = hits_ = 0;
  opened_less_ = false;
  adapted_ = 0;
  shifted_.clear();
  stability_.reset();
  inspected_.clear();
  pressed_harder_ = holds_ = false;
  slid_ = 0;
  holding_.begin();
}

void ArmCycle::begin(const Action& action) {
  switch (action.primitive) {
    case Primitive::kLook:
    case Primitive::kDecide:
    case Primitive::kView:
      return;  // Cycle's
    case Primitive::kApproach:
    case Primitive::kTouch:
    case Primitive::kProbe:
    case Primitive::kPush:
      return open_hand(Step::kOpen, described(grasp(), grasp_index()) + ": opening the hand");
    case Primitive::kGrasp: {
      if (is_probe()) return ended(Outcome::kDone);  // it has felt all that it is to feel
      gently_ = action.gently;
      if (hand_.feels_its_grip()) return close();
      const bool regulates =
          wanted_force() > 0 && !grasp().largest_effort.empty() && !percepts_.pads.empty();
      share_ = regulates || gently_ ? robot::first_effort_share(gently_ ? 0 : grasp().effort) : 1;
      return gather();
    }
    case Primitive::kInspect:
      return begin_inspection();
    case Primitive::kLift:
      gripped_percepts_ = percepts_;
      begin_hold();
      lift_is_free_ = false;
      begin_segment(Step::kLift, held_collision_force() + pressed_force());
      return;
    case Primitive::kMove:
      return begin_move(action);
    case Primitive::kPlace:
      return begin_place();
    case Primitive::kRelease:
      holds_ = false;
      return open_to_release();
    case Primitive::kRetreat:
      return is_at_place() && failure().empty() ? retreat() : go_back();
    case Primitive::kWait:
      wait_time_ = action.seconds;
      return enter(Step::kWait, fmt::format("waiting for {:.3g} s", action.seconds));
  }
}

void ArmCycle::begin_move(const Action& action) {
  switch (action.goal) {
    case Action::Goal::kPlace:
      if (!segment(SegmentKind::kPlace))
        return ended(Outcome::kNothing, "the plan puts it nowhere");
      begin_segment(Step::kCarry, held_collision_force());
      return;
    case Action::Goal::kLowered: {
      const JointTrajectory* lift = segment(SegmentKind::kLift);
      if (!lift) return ended(Outcome::kDone);
      enter(Step::kLower, "lowering it");
      lowers_fully_ = action.share >= 1;
      lowered_ = part_of(reversed(*lift), action.share);
      return follow(*lowered_, lowers_fully_ ? contact_force_down() : held_collision_force(),
                    false);
    }
    case Action::Goal::kLifted:
      enter(Step::kRaise, "lifting it again");
      if (!lowered_) return;
      // It is as high as it was lifted: there is another way back again.
      if (lowers_fully_) gone_.push_back(reversed(*lowered_));
      return follow(reversed(*lowered_), held_collision_force(), false);
  }
}

// `leads_back`: it is to be gone back when the arm goes back.
void ArmCycle::follow(const JointTrajectory& path, double contact_force, bool leads_back,
                      FromHere from_here_on) {
  refused_.clear();
  try {
    const JointTrajectory from_here =
        from_here_on(path, percepts_.names, percepts_.positions, options_.largest_detour);
    if (leads_back) gone_.push_back(from_here);
    arm_.follow(from_here, contact_force);
  } catch (const std::invalid_argument& error) {
    refused_ = error.what();
  }
}

const JointTrajectory* ArmCycle::segment(SegmentKind kind) const {
  for (const auto& [one, path] : grasp().segments) {
    if (one == kind) return &path;
  }
  return nullptr;
}

std::optional<SegmentKind> ArmCycle::segment_of(Step step) {
  switch (step) {
    case Step::kReach:
      return SegmentKind::kReach;
    case Step::kApproach:
      return SegmentKind::kApproach;
    case Step::kLift:
      return SegmentKind::kLift;
    case Step::kCarry:
      return SegmentKind::kCarry;
    case Step::kPlace:
      return SegmentKind::kPlace;
    case Step::kRetreat:
      return SegmentKind::kRetreat;
    default:
      return std::nullopt;
  }
}

void ArmCycle::begin_segment(Step step, double contact_force) {
  const SegmentKind kind = segment_of(step).value();
  enter(step, std::string("arm: ") + motion::to_string(kind));
  if (const JointTrajectory* path = segment(kind)) follow(*path, contact_force);
}

void ArmCycle::begin_place() {
  const JointTrajectory* way = segment(SegmentKind::kPlace);
  // Below where it is to stand, only what feels it finds out that it does.
  const bool feels = options_.reacts && percepts_.wrist_force;
  if (!way || feels || grasp().place_share >= 1) {
    time_to_stand_ = way ? grasp().place_share * way->duration() : 0;
    return begin_segment(Step::kPlace, contact_force_down());
  }
  const JointTrajectory to_there = part_of(*way, grasp().place_share);
  time_to_stand_ = to_there.duration();
  enter(Step::kPlace, "arm: place");
  follow(to_there, contact_force_down());
}

// To so far past where they are to touch: with the efforts that they have now.
void ArmCycle::drive_fingers(double past) {
  const Eigen::VectorXd goal = grasp().hand.at(past);
  hand_.move(grasp().hand_joints, {goal.begin(), goal.end()}, options_.closing_speed, true,
             efforts());
}

void ArmCycle::gather() {
  if (options_.gather == 0) return close();
  drive_fingers(-options_.gather);
  enter(Step::kGather, "gathering the fingers round the object");
}

void ArmCycle::close() {
  drive_fingers(options_.overrun);
  enter(Step::kClose,
        hand_.feels_its_grip() ? "closing until both pads touch" : "closing the fingers");
}

double ArmCycle::wanted_force() const {
  return grasp().force > 0 ? grasp().force : options_.grip_force;
}

std::vector<double> ArmCycle::efforts() const {
  std::vector<double> efforts = grasp().largest_effort;
  for (double& effort : efforts) effort *= share_;
  return efforts;
}

void ArmCycle::press() {
  drive_fingers(options_.overrun);
  enter(Step::kPress, fmt::format("pressing until the pads feel {:.1f} N", wanted_force()));
}

void ArmCycle::after_pressing() {
  if (hand_.feels_its_grip()) {
    if (!pressed_harder_) compare_touch();
    return judge_grip();
  }
  if (spent() < robot::kPressTime) return;
  const MeanTouch felt = mean_touch(percepts_.pads, options_.touch_force, options_.stale_time);
  const auto share = robot::next_effort_share(share_, felt, wanted_force());
  if (!share || now() - pressed_since_ > options_.force_timeout) {
    return enter(Step::kSettle, "pressing");
  }
  share_ = *share;
  press();
}

}  // namespace prehend::control
