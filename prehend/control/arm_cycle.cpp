#include "prehend/control/arm_cycle.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/geometry/gravity.h"
#include "prehend/text/require.h"

namespace prehend::control {
namespace {

using motion::SegmentKind;

constexpr double kMeetTime = 0.2;   // s, that a probe stands at what it has met
constexpr double kFreeShare = 0.5;  // of the lift's limit: what the grip pressed down is clear
constexpr const char* kLooksAgain = "lets go and looks again";

// A probe or a push is the last.
std::vector<GraspPose> poses_of(const std::vector<ArmGrasp>& grasps) {
  std::vector<GraspPose> poses;
  for (const ArmGrasp& grasp : grasps) {
    if (grasp.is_grasp()) poses.push_back(grasp.pose);
  }
  return poses;
}

}  // namespace

void ArmCycleOptions::validate() const {
  SharedCycleOptions::validate();
  GripOptions::validate("ArmCycleOptions.");
  knobs(*this, text::CheckKnobs{"ArmCycleOptions."});
  holding.validate();
  slip.validate();
}

std::string described(const ArmGrasp& grasp, int index) {
  if (grasp.probe_H) return "probe with one fingertip";
  if (grasp.pushes) return "push along the table";
  return fmt::format("grasp {} (score {:.2f}, {})", index, grasp.score,
                     grasp.robustness < 0 ? std::string("robustness not assessed")
                                          : fmt::format("held in {:.0f} % of the disturbed trials",
                                                        100 * grasp.robustness));
}

ArmCycle::ArmCycle(const ArmCycleOptions& options, ArmPort& arm, HandPort& hand)
    : Cycle(options),
      options_(options),
      arm_(arm),
      hand_(hand),
      hold_slip_(options.slip),
      holding_(options.holding) {
  options.validate();
}

bool ArmCycle::moves_hand() const {
  return step_ == Step::kOpen || step_ == Step::kGather || step_ == Step::kFeel ||
         step_ == Step::kLoosen || step_ == Step::kClose || step_ == Step::kPress ||
         step_ == Step::kHarder || step_ == Step::kRelease || step_ == Step::kLoosenHold;
}

bool ArmCycle::waits() const {
  return step_ == Step::kRest || step_ == Step::kSettle || step_ == Step::kCheck ||
         step_ == Step::kVerify || step_ == Step::kWait || step_ == Step::kBrake ||
         step_ == Step::kMet || step_ == Step::kStill || step_ == Step::kAtView;
}

bool ArmCycle::leaves() const {
  return step_ == Step::kRelease || step_ == Step::kRelieve || step_ == Step::kPutBack ||
         step_ == Step::kLoosenHold || step_ == Step::kRetreat || step_ == Step::kGoBack;
}

void ArmCycle::enter(Step step, const std::string& detail) {
  step_ = step;
  entered(detail);
}

void ArmCycle::start(std::vector<ArmGrasp> grasps, const std::string& problem, Advice advice) {
  text::Require{"ArmCycleOptions."}(options_.minimum_stability == 0 || judge_.has_value(),
                                    "minimum_stability needs a judge of grips");
  grasps_ = std::move(grasps);
  detail_ = "waiting for percepts";
  start_task(poses_of(grasps_), problem, std::move(advice));
}

std::vector<InputAge> ArmCycle::inputs() {
  const auto age = [](bool has_come, double seconds) {
    return has_come ? std::optional(seconds) : std::nullopt;
  };
  std::vector<InputAge> all = {
      {"the joints' states", age(!percepts_.names.empty(), percepts_.joints_age),
       options_.stale_time},
      {"the wrist's force", age(percepts_.wrist_force.has_value(), percepts_.wrist_age),
       options_.stale_time},
      {"the server of the arm's motion", arm_.answer_age(), options_.answer_time},
      {"the server of the hand's motion", hand_.answer_age(), options_.answer_time}};
  const std::vector<InputAge> of_hand = hand_.inputs();
  all.insert(all.end(), of_hand.begin(), of_hand.end());
  return all;
}

void ArmCycle::step_waiting() {
  if (grasps_.empty()) return;                  // not started
  if (phase_times().empty()) entered(detail_);  // the clock was not known before
  const std::vector<InputAge> missing = stale_inputs(inputs());
  if (missing.empty()) return begin_task();
  detail_ = "waiting for " + names_of(missing);
  if (spent() > options_.motion_timeout) {
    finish(false, "nothing was moved, for want of " + describe(missing));
  }
}

bool ArmCycle::stop_when_lost() {
  const std::vector<InputAge> lost = watch_.lost(now(), inputs());
  if (lost.empty()) return false;
  abort("lost " + describe(lost) + " while " + detail_ + "; arm and hand were stopped");
  return true;
}

void ArmCycle::stop_motion() {
  arm_.stop();
  hand_.stop();
  if (inspection_ && step_ == Step::kInspect) inspection_->stop();
  if (lift_view_ && step_ == Step::kCheck) lift_view_->stop();
}

void ArmCycle::fail(const std::string& reason) {
  if (leaves()) return ended(Outcome::kFailed, reason);
  if (step_ == Step::kToView) return look_failed(reason);
  if (step_ == Step::kFromView)
    return abort("the arm stands where its camera looked from: " + reason);
  const std::string what = grasp().pushes || is_probe() ? described(grasp(), grasp_index())
                                                        : fmt::format("grasp {}", grasp_index());
  // The first step of what is no grasp says what it is.
  const std::string said = reason.starts_with(what + ": ") ? reason : what + ": " + reason;
  if (inspects()) return give_up(said, SurpriseKind::kMotion, Outcome::kLost);
  give_up(said);
}

void ArmCycle::take_plan(std::vector<ArmGrasp> grasps, const std::string& problem, Advice advice) {
  if (!waits_for_plan()) return;
  std::vector<GraspPose> poses = poses_of(grasps);
  // Without grasps those of the plan before stay; a push of before is not done again.
  std::erase_if(grasps_, [](const ArmGrasp& one) { return one.pushes; });
  if (!grasps.empty()) grasps_ = std::move(grasps);
  plan_taken(std::move(poses), problem, std::move(advice));
}

// A segment that the plan does not have ends at once.
MotionStatus ArmCycle::motion_status() {
  if (moves_hand()) return hand_.motion();
  if (waits()) return MotionStatus::kReached;
  if (step_ == Step::kInspect) {
    return inspection_->status() == MotionStatus::kMoving ? MotionStatus::kMoving
                                                          : MotionStatus::kReached;
  }
  if (!refused_.empty()) return MotionStatus::kFailed;
  const std::optional<SegmentKind> kind = segment_of(step_);
  const bool planned =
      step_ == Step::kGoBack || step_ == Step::kRelieve || step_ == Step::kPutBack ||
      step_ == Step::kShift || step_ == Step::kBackOff || step_ == Step::kLower ||
      step_ == Step::kSetDown || step_ == Step::kTurnBack || step_ == Step::kToView ||
      step_ == Step::kFromView || (step_ == Step::kTurn && !grasp().views[view_].points.empty()) ||
      (step_ == Step::kRaise && lowered_.has_value()) || (kind && segment(*kind) != nullptr);
  return planned ? arm_.motion() : MotionStatus::kReached;
}

void ArmCycle::step(const ArmPercepts& percepts) {
  advance_to(percepts.time);
  percepts_ = percepts;
  if (finished()) return;
  hand_.step(percepts_);
  if (waits_for_inputs()) return step_waiting();
  if (const std::string fault = hand_.fault(); !fault.empty()) return abort(fault);
  if (waits_for_plan()) return step_look();
  if (stop_when_lost()) return;
  if (watch_held() || judge_lift() || watch_slip()) return;
  MotionStatus status = motion_status();
  const bool meets = step_ == Step::kApproach && !grasp().pushes &&
                     (hand_.touches() || (is_probe() && pads_meet()));
  if (status == MotionStatus::kMoving && (meets || hits_on_lift())) {
    arm_.stop();
    status = MotionStatus::kContact;
  }
  if (status == MotionStatus::kMoving) {
    if (opens_onto_something()) return relieve(true);
    if (step_ == Step::kInspect || spent() <= options_.motion_timeout) return;
    stop_motion();
    return fail(detail_ + " took too long");
  }
  if (status == MotionStatus::kFailed && leaves_jammed()) return;
  if (status == MotionStatus::kFailed) {
    std::string why = detail_ + ": ";
    why += moves_hand() ? hand_.problem() : (refused_.empty() ? arm_.problem() : refused_);
    if (step_ == Step::kRetreat) add_surprise(SurpriseKind::kMotion, 1, 0, "ends");
    if (step_ == Step::kClose) add_surprise(SurpriseKind::kFingersTouch, 1, 0, kLooksAgain);
    return fail(why);
  }
  if (status == MotionStatus::kContact && !moves_hand() && !reacts_to_contact()) {
    if (retreats_on() || stays_before_hit()) return;
    return fail(fmt::format("{}: the arm hit something, the wrist felt {:.0f} N", detail_,
                            felt_contact(0)));
  }
  advance(status);
}

bool ArmCycle::reacts_to_contact() const {
  switch (step_) {
    case Step::kPlace:
    case Step::kPutBack:
    case Step::kSetDown:
      return true;
    case Step::kLower:
      return lowers_fully_;
    case Step::kApproach:
      return options_.reacts || hand_.feels_its_grip() || primitive() == Primitive::kTouch ||
             !grasp().is_grasp();
    default:
      return false;
  }
}

// What is predicted to be held counts double, as its mass is a guess.
double ArmCycle::held_collision_force() const {
  return options_.collision_force +
         std::max(2 * geometry::kGravity * grasp().lifted_mass, holding_.weight().value_or(0));
}

// By which fingers that close press what they grip on what it stands on: the lift takes it away.
double ArmCycle::pressed_force() const {
  return percepts_.wrist_force ? percepts_.wrist_force->norm() : 0;
}

// Only until that has gone is it allowed for: an arm that hits something above the table stops at
// what counts on any other way.
bool ArmCycle::hits_on_lift() {
  if (step_ != Step::kLift) return false;
  const double felt = pressed_force(), limit = held_collision_force();
  lift_is_free_ = lift_is_free_ || felt < kFreeShare * limit;
  return lift_is_free_ && felt > limit;
}

// Begins once the arm has come to rest; true until it has ended.
bool ArmCycle::looks_at_lift() {
  if (!lift_view_) return false;
  if (!lift_looked_at_) {
    if (spent() < options_.rest_time) return true;
    lift_view_->look(gripped_percepts_, percepts_);
    lift_looked_at_ = true;
  }
  return lift_view_->status() == MotionStatus::kMoving;
}

double ArmCycle::contact_force_down() const {
  return options_.reacts ? holding_.weight().value_or(0) + options_.contact_force
                         : held_collision_force();
}

// To the next step, as this one has ended by `status` or waits.
void ArmCycle::advance(MotionStatus status) {
  switch (step_) {
    case Step::kOpen:
      begin_segment(Step::kReach, options_.collision_force);
      return;
    case Step::kReach:
      return enter(Step::kRest, "reading the wrist at rest");
    case Step::kRest: {
      holding_.feel_free(percepts_.wrist_force);
      if (spent() < options_.rest_time) return;
      sums_at_rest_.clear();
      for (const PadPercept& pad : percepts_.pads) sums_at_rest_[pad.name] = pad.sum;
      const bool feels = options_.reacts || primitive() == Primitive::kTouch;
      const double force = feels ? options_.contact_force : options_.collision_force;
      begin_segment(Step::kApproach, is_probe() ? options_.probe_force
                                                : (grasp().pushes ? options_.push_force : force));
      return;
    }
    case Step::kApproach:
      return after_approach(status);
    case Step::kMet:
      if (spent() < kMeetTime) return;
      return ended(Outcome::kDone);
    case Step::kBackOff:
      return ended(Outcome::kDone);
    case Step::kFeel:
      if (!adapt(true)) ended(Outcome::kDone);
      return;
    case Step::kLoosen:
      return shift();
    case Step::kShift:
      return approach_again();
    case Step::kGather:
      return close();
    case Step::kClose:
      return after_closing(status);
    case Step::kPress:
      return after_pressing();
    case Step::kHarder:
      return enter(Step::kSettle, "pressing");
    case Step::kSettle:
      if (spent() < options_.settle_time) return;
      if (!pressed_harder_) compare_touch();
      if (const auto now = closure()) {
        const double sent = grasp().hand.closure(grasp().hand.at(options_.overrun));
        holding_.grip(now, sent - *now);
        gripped_ = *now;
      }
      return judge_grip();
    case Step::kLift:
      holding_.begin_weighing();
      lift_looked_at_ = false;
      return enter(Step::kCheck, "weighing what is held");
    case Step::kCheck:
      holding_.weigh(percepts_.wrist_force);
      if (looks_at_lift() || spent() < options_.check_time) return;
      return check();
    case Step::kBrake:
      return set_down();
    case Step::kSetDown:
      return after_setting_down();
    case Step::kPlace:
      return after_placing(status);
    case Step::kLower:
      if (lowers_fully_) {
        put_down_ = true;
        if (!gone_.empty()) gone_.pop_back();
      }
      return ended(Outcome::kDone);
    case Step::kCarry:
    case Step::kRaise:
    case Step::kRelease:
      return ended(Outcome::kDone);
    case Step::kPutBack:
      return open_less();
    case Step::kRelieve:
      return opens_on_ ? open_to_release() : retreat();
    case Step::kLoosenHold:
      return retreat();
    case Step::kRetreat:
      holding_.begin_weighing();
      return enter(Step::kVerify, "looking whether the hand is empty");
    case Step::kVerify:
      holding_.weigh(percepts_.wrist_force);
      if (spent() < options_.check_time) return;
      return verify();
    case Step::kGoBack:
      return go_back();
    case Step::kTurn:
      return enter(Step::kStill, "holding it still before the camera");
    case Step::kStill:
      if (spent() < options_.rest_time) return;
      return look_at_held();
    case Step::kInspect:
      return after_look();
    case Step::kTurnBack:
      return next_view();
    case Step::kToView:
      return enter(Step::kAtView, "holding the camera still");
    case Step::kAtView:
      if (spent() < options_.rest_time) return;
      return look_now();
    case Step::kFromView:
      return view_left();
    case Step::kWait:
      if (spent() < wait_time_) return;
      return ended(Outcome::kDone);
  }
}

}  // namespace prehend::control
