// What the cycle of arm and hand feels, compared with what was predicted.

#include <algorithm>

#include <fmt/format.h>

#include "prehend/control/arm_cycle.h"
#include "prehend/geometry/gravity.h"

namespace prehend::control {
namespace {

constexpr double kHighAboveTable = 0.7;  // of the way down: until then nothing else can bear it

}  // namespace

// On the way down to a place, it is above all that was to bear what is held.
bool ArmCycle::is_high() const {
  return time_to_stand_ > 0 && spent() < kHighAboveTable * time_to_stand_;
}

// How far the fingers have closed beyond the predicted touch [rad], by the joints' states.
std::optional<double> ArmCycle::closure() const {
  const std::vector<std::string>& joints = grasp().hand_joints;
  Eigen::VectorXd positions(static_cast<Eigen::Index>(joints.size()));
  for (std::size_t i = 0; i < joints.size(); ++i) {
    // A hand's own names are its platform's without the prefix.
    auto found = std::find(percepts_.names.begin(), percepts_.names.end(), joints[i]);
    if (found == percepts_.names.end()) {
      found = std::find(percepts_.names.begin(), percepts_.names.end(), "hand_" + joints[i]);
    }
    if (found == percepts_.names.end()) return std::nullopt;
    positions[static_cast<Eigen::Index>(i)] =
        percepts_.positions.at(static_cast<std::size_t>(found - percepts_.names.begin()));
  }
  return grasp().hand.closure(positions);
}

// The force that has stopped the arm [N]: what was asked for at least, as it may be gone by now.
double ArmCycle::felt_contact(double borne) const {
  return std::max(percepts_.wrist_force ? percepts_.wrist_force->norm() : 0,
                  borne + options_.contact_force);
}

void ArmCycle::after_approach(MotionStatus status) {
  const bool touches = status == MotionStatus::kContact;
  if (grasp().pushes) return ended(Outcome::kDone);
  if (is_probe()) {
    if (!touches) return ended(Outcome::kDone, "it met nothing");
    return enter(Step::kMet, "feeling what the fingertip has met");
  }
  if (primitive() == Primitive::kTouch) {
    return ended(touches ? Outcome::kDone : Outcome::kNothing, touches ? "" : "nothing was met");
  }
  if (touches && hand_.feels_its_grip()) {
    // What stands in a jaw's way is not between the jaws, but the object may be by now.
    const double felt = felt_contact(0);
    // A pad that feels it has it between the jaws, wedged: left so, the open hand takes it along.
    const bool is_between = options_.reacts && options_.largest_shortfall > 0 && hand_.touches(),
               goes_back = back_off(is_between);
    add_surprise({SurpriseKind::kTouchedTooEarly, 0, felt, 0, true,
                  goes_back ? "goes back a little and closes there"
                            : (is_between ? "closes there" : "lets go and looks again")});
    if (goes_back) return;
    if (is_between) return ended(Outcome::kDone);
    return fail("touched something on the approach");
  }
  if (touches) {
    const bool adapts = feel();
    add_surprise(SurpriseKind::kTouchedTooEarly, 0, felt_contact(0),
                 adapts ? "feels where it is" : "closes where it touches");
    if (adapts) return;
  }
  ended(Outcome::kDone);
}

void ArmCycle::after_closing(MotionStatus status) {
  // Fingers that get to the end of their way touch nothing.
  const bool touch = status == MotionStatus::kContact;
  add_surprise(SurpriseKind::kFingersTouch, 1, touch ? 1 : 0, "lets go and looks again");
  if (!touch) return fail("the fingers closed on nothing");
  if (hand_.feels_its_grip()) {
    add_surprise(SurpriseKind::kOpeningAtContact, 2 * grasp().hand.closed[0], hand_.opening(),
                 gently_ ? "lets go" : "grip what is there");
    if (gently_) return ended(Outcome::kDone);
    hand_.press();
    return enter(Step::kPress, fmt::format("both pads touch at {:.1f} mm, rising to {:.1f} N",
                                           1e3 * hand_.opening(), grasp().force));
  }
  const std::vector<double> positions = hand_.positions();
  if (positions.size() == grasp().hand_joints.size()) {
    const double beyond = grasp().hand.closure(Eigen::Map<const Eigen::VectorXd>(
        positions.data(), static_cast<Eigen::Index>(positions.size())));
    if (!gently_ && adapt(false)) {
      add_surprise(SurpriseKind::kFingersAtContact, grasp().closure, beyond, "shifts the hand");
      return;
    }
    add_surprise(SurpriseKind::kFingersAtContact, grasp().closure, beyond,
                 gently_ ? "lets go" : "grips anyhow, weighs it when lifted");
  }
  if (gently_) return ended(Outcome::kDone);
  if (share_ >= 1) return enter(Step::kSettle, "pressing");
  pressed_since_ = now();
  press();
}

void ArmCycle::compare_touch() {
  const MeanTouch felt = mean_touch(percepts_.pads, options_.touch_force, options_.stale_time);
  if (percepts_.pads.empty()) return;
  const std::string reaction = "grips anyhow, weighs it when lifted";
  if (grasp().contact_area > 0) {
    add_surprise(SurpriseKind::kContactArea, grasp().contact_area, felt.area, reaction);
  }
  if (grasp().tactile_sum > 0) {
    add_surprise(SurpriseKind::kTactileSum, grasp().tactile_sum, felt.sum, reaction);
  }
}

bool ArmCycle::watch_held() {
  const bool lifting = step_ == Step::kLift, carrying = step_ == Step::kCarry,
             placing = step_ == Step::kPlace;
  const bool shaking = step_ == Step::kLower || step_ == Step::kRaise;
  if (!lifting && !carrying && !placing && !shaking && !inspects()) return false;
  bool by_weight = carrying || inspects();
  if (placing) by_weight = is_high();
  const bool rests = placing || (step_ == Step::kLower && lowers_fully_);
  const std::string why = hand_.feels_its_grip()
                              ? (lifting ? std::string() : hand_.lost(rests))
                              : holding_.lost(now(), percepts_.wrist_force, closure(), by_weight);
  if (why.empty()) return false;
  add_surprise(lifting ? SurpriseKind::kHeldAfterLift : SurpriseKind::kHeldWhileCarried, 1, 0,
               "lets go and looks again");
  give_up(fmt::format("grasp {}: lost while {}: {}", grasp_index(),
                      lifting || step_ == Step::kRaise
                          ? "lifting"
                          : (carrying ? "carrying" : (inspects() ? "turning" : "lowering")),
                      why),
          SurpriseKind::kMotion, Outcome::kLost);
  return true;
}

void ArmCycle::check() {
  Holding::Verdict held = holding_.held(closure());
  if (hand_.feels_its_grip()) {
    const std::string why = hand_.lost(false);
    held = {why.empty(), why.empty() ? hand_.grip() : why};
  }
  add_surprise(SurpriseKind::kHeldAfterLift, 1, held.yes ? 1 : 0, "lets go and looks again");
  if (!held.yes) {
    return give_up(
        fmt::format("grasp {}: nothing is held after the lift: {}", grasp_index(), held.why),
        SurpriseKind::kMotion, Outcome::kLost);
  }
  if (grasp().lifted_mass > 0 && holding_.weight()) {
    add_surprise(SurpriseKind::kLiftedWeight, grasp().lifted_mass * geometry::kGravity,
                 *holding_.weight(), "carries what it weighs");
  }
  achieved(fmt::format("{}: lifted and held ({}{})", described(grasp(), grasp_index()), held.why,
                       foretold() + slipped()));
  ended(Outcome::kDone);
}

void ArmCycle::after_placing(MotionStatus status) {
  // Near its end the way is meant to meet what bears the object.
  if (status == MotionStatus::kContact && is_high()) {
    const double weight = holding_.weight().value_or(0);
    add_surprise(SurpriseKind::kTouchedTooEarly, weight, felt_contact(weight),
                 "opens where it touches");
  }
  add_surprise(SurpriseKind::kHeldWhileCarried, 1, 1, "");
  put_down_ = true;
  ended(Outcome::kDone);
}

void ArmCycle::verify() {
  Holding::Verdict empty = holding_.empty();
  if (hand_.feels_its_grip()) {
    const std::string felt = hand_.still_felt();
    empty = {felt.empty(), felt.empty() ? "the hand is empty" : felt};
  }
  const bool leaves_again = !empty.yes && !hand_.feels_its_grip() && !opened_less_ &&
                            is_at_place() && !gone_.empty() &&
                            segment(motion::SegmentKind::kRetreat);
  add_surprise(SurpriseKind::kPlaced, 1, empty.yes ? 1 : 0,
               leaves_again ? "puts it back and opens less" : "ends");
  if (leaves_again) return put_back();
  const std::string name = described(grasp(), grasp_index());
  if (!empty.yes) {
    return ended(Outcome::kFailed,
                 name + ": what was to be put down did not leave the hand: " + empty.why);
  }
  achieved(fmt::format("{}: lifted{}{}, held all the way{}, put down{}; {}", name,
                       holding_.weight() ? fmt::format(" {:.2f} N", *holding_.weight()) : "",
                       inspected_, foretold() + slipped(), is_at_place() ? "" : " where it stood",
                       empty.why));
  ended(Outcome::kDone);
}

}  // namespace prehend::control
