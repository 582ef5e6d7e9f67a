// What the cycle of arm and hand does when what it holds slips over its pads.

#include <algorithm>

#include <fmt/format.h>

#include "prehend/control/arm_cycle.h"

namespace prehend::control {
namespace {

constexpr double kAlone = 0.7;         // of a way down: until then nothing else bears it
constexpr double kBeforeLift = 0.1;    // s, of frames of the grip at rest
constexpr double kBrakeTime = 0.3;     // s, that an arm takes to stand
constexpr double kShortestWay = 0.01;  // of the lift, that is lowered

}  // namespace

void ArmCycle::begin_hold() {
  hold_slip_.begin(now() - kBeforeLift);
  holds_ = true;
}

// Where the object rests on something, it may be pushed over the pads.
bool ArmCycle::bears_alone() const {
  if (!holds_) return false;
  switch (step_) {
    case Step::kLift:
    case Step::kCheck:
    case Step::kCarry:
    case Step::kRaise:
    case Step::kWait:
      return true;
    case Step::kPlace:
      return time_to_stand_ > 0 && spent() < kAlone * time_to_stand_;
    case Step::kLower:
      return lowered_ && (!lowers_fully_ || spent() < kAlone * lowered_->duration());
    default:
      return false;
  }
}

// It has slipped with what the pads feel now: the next grasp of it begins with more.
void ArmCycle::remember_slip() {
  const MeanTouch felt = mean_touch(percepts_.pads, options_.touch_force, options_.stale_time);
  double force = options_.slip_force_factor * felt.sum;
  if (options_.largest_grip_force > 0) force = std::min(force, options_.largest_grip_force);
  least_force_ = std::max(least_force_, force);
}

bool ArmCycle::hold_harder() {
  if (hand_.feels_its_grip()) {
    return hand_.hold_harder(options_.slip_force_factor, options_.largest_grip_force);
  }
  if (share_ >= 1 || grasp().largest_effort.empty()) return false;
  const MeanTouch felt = mean_touch(percepts_.pads, options_.touch_force, options_.stale_time);
  double factor = options_.slip_force_factor;
  if (options_.largest_grip_force > 0 && felt.sum > 0) {
    factor = std::min(factor, options_.largest_grip_force / felt.sum);
  }
  if (!(factor > 1)) return false;
  share_ = std::min(1.0, factor * share_);
  drive_fingers(options_.overrun);
  return true;
}

bool ArmCycle::watch_slip() {
  if (percepts_.frames.empty()) return false;
  double age = 0;
  for (const PadPercept& pad : percepts_.pads) age = std::max(age, pad.age);
  const touch::HoldSlipReading& felt =
      hold_slip_.update(now() - age, percepts_.frames, percepts_.wrist_force);
  if (!felt.slips || !bears_alone()) return false;
  const double slide = felt.slide;
  slid_ += slide;
  remember_slip();
  if (options_.slip_force_factor > 1 && hold_harder()) {
    // What is felt while the force rises is compared with nothing.
    hold_slip_.begin(now() + options_.slip_settle_time);
    add_surprise(SurpriseKind::kSlip, 0, slide, "holds harder");
    return false;
  }
  if (options_.slip_force_factor > 1 && slid_ <= options_.largest_slide) {
    hold_slip_.begin(now() + options_.slip_settle_time);
    add_surprise(SurpriseKind::kSlip, 0, slide, "carries on, as it cannot hold harder");
    return false;
  }
  holds_ = false;  // it is said once: there is nothing more to be done about it
  const bool lifted = step_ == Step::kLift || step_ == Step::kCheck || step_ == Step::kRaise;
  if (options_.slip_force_factor <= 1 || !lifted || !segment(motion::SegmentKind::kLift)) {
    const bool down = step_ == Step::kPlace || step_ == Step::kLower;
    add_surprise(SurpriseKind::kSlip, 0, slide,
                 options_.slip_force_factor <= 1
                     ? "carries on, as slip_force_factor is 1"
                     : (down ? "goes on lowering it, as it cannot hold harder"
                             : "carries on to where it is put down, as it cannot hold harder"));
    return false;
  }
  add_surprise(SurpriseKind::kSlip, 0, slide, "cannot hold harder: puts it down and looks again");
  arm_.stop();
  enter(Step::kBrake, "it slips, and the hand cannot hold harder");
  return true;
}

// The way of the lift back, as far as it has come.
void ArmCycle::set_down() {
  if (spent() < kBrakeTime) return;
  const JointTrajectory& lift = *segment(motion::SegmentKind::kLift);
  const double gone = nearest_on(lift, percepts_.names, percepts_.positions).share;
  enter(Step::kSetDown, "putting down what slips");
  follow(reversed(part_of(lift, std::max(gone, kShortestWay))), contact_force_down(), false);
}

void ArmCycle::after_setting_down() {
  if (!gone_.empty()) gone_.pop_back();  // the lift, which was gone back
  give_up(fmt::format("grasp {}: it slipped by {:.1f} mm as it was lifted, and the hand cannot "
                      "hold harder: put down again",
                      grasp_index(), 1e3 * slid_),
          SurpriseKind::kSlip, Outcome::kLost);
}

std::string ArmCycle::slipped() const {
  return slid_ > 0 ? fmt::format(", although it slipped by {:.1f} mm", 1e3 * slid_) : "";
}

}  // namespace prehend::control
