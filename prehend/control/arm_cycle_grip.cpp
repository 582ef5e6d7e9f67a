// What the cycle of arm and hand does when its pads tell how likely the lift holds.

#include <algorithm>

#include <fmt/format.h>

#include "prehend/control/arm_cycle.h"

namespace prehend::control {
namespace {

constexpr double kHarder = 1.5;  // times the force, of one more try
constexpr double kHelps = 0.02;  // of probability, that it must gain

}  // namespace

std::string ArmCycle::foretold() const {
  return stability_ ? fmt::format(", as its pads foretold with {:.0f} %", 100 * *stability_) : "";
}

void ArmCycle::judge_grip() {
  if (judge_) stability_ = judge_->closed(percepts_, grasp().hand_joints, hand_.positions());
  if (!stability_ || *stability_ >= options_.minimum_stability) return ended(Outcome::kDone);
  if (!pressed_harder_ && judge_->if_pressed(kHarder) > *stability_ + kHelps && press_harder()) {
    pressed_harder_ = true;
    return;
  }
  fail(fmt::format("the pads foretell that the lift holds with {:.0f} %, less than {:.0f} %",
                   100 * *stability_, 100 * options_.minimum_stability));
}

bool ArmCycle::press_harder() {
  const std::string detail =
      fmt::format("pressing harder, as the lift would hold with {:.0f} %", 100 * *stability_);
  if (hand_.feels_its_grip()) {
    if (!hand_.press_harder(kHarder)) return false;
    enter(Step::kPress, detail);
    return true;
  }
  if (share_ >= 1) return false;
  share_ = std::min(1.0, kHarder * share_);
  const Eigen::VectorXd goal = grasp().hand.at(options_.overrun);
  hand_.move(grasp().hand_joints, {goal.begin(), goal.end()}, options_.closing_speed, true,
             efforts());
  enter(Step::kHarder, detail);
  return true;
}

bool ArmCycle::judge_lift() {
  if (!judge_ || step_ != Step::kLift) return false;
  const auto now = judge_->lifting(percepts_, grasp().hand_joints, hand_.positions());
  if (!now) return false;
  stability_ = now;
  if (*now >= options_.minimum_stability) return false;
  add_surprise(SurpriseKind::kHeldAfterLift, 1, 0, "lets go and looks again");
  give_up(fmt::format("grasp {}: given up after {:.0f} mm of the lift: the pads foretell that it "
                      "holds with {:.0f} %, less than {:.0f} %",
                      grasp_index(), 1e3 * kAskedWhenRisen, 100 * *now,
                      100 * options_.minimum_stability),
          SurpriseKind::kMotion, Outcome::kLost);
  return true;
}

}  // namespace prehend::control
