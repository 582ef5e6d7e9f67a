#include "prehend/control/percept_watch.h"

#include <utility>

#include "prehend/control/hand_sample.h"

namespace prehend::control {

PerceptWatch::PerceptWatch(const robot::Platform& platform, double touch_force, int touch_counts)
    : platform_(platform),
      chain_(platform.arm_chain()),
      touch_force_(touch_force),
      touch_counts_(touch_counts) {}

std::optional<belief::ActMoment> PerceptWatch::moment(const ArmPercepts& percepts) {
  const auto hand = hand_sample(platform_, chain_, percepts);
  if (!hand) return std::nullopt;
  X_WH_ = hand->X_WH;
  belief::ActMoment now;
  now.time = percepts.time;
  now.motors.resize(platform_.hand.size());
  for (int m = 0; m < platform_.hand.size(); ++m) {
    now.motors[m] = hand->joints[platform_.hand.actuated[static_cast<std::size_t>(m)]];
  }
  if (percepts.wrist_force && percepts.wrist_torque) {
    now.wrist = belief::Wrench{*percepts.wrist_force, *percepts.wrist_torque};
  }
  now.pads.resize(platform_.hand.pads.size());
  for (const touch::PadFrame& frame : percepts.frames) {
    for (std::size_t i = 0; i < now.pads.size(); ++i) {
      if (platform_.hand.pads[i].name != frame.pad) continue;
      if (frame.counts.size() != frame.felt->layout.size()) continue;
      now.pads[i] = belief::pad_image(frame.felt->layout, frame.counts,
                                      frame.felt->newton_per_count, touch_counts_);
    }
  }
  return now;
}

void PerceptWatch::conclude() {
  perceived_ = act_->percepts();
  grasp_index_ = act_grasp_;
  tries_ = act_tries_;
  ++concluded_;
  act_.reset();
}

void PerceptWatch::step(const ArmCycle& cycle, const ArmPercepts& percepts) {
  const Phase phase = cycle.phase();
  const bool anew = act_ && cycle.result().tries() != act_tries_;
  if (act_ && phase_ == Phase::kGrasp && (phase != Phase::kGrasp || anew)) act_->closed(now_);
  if (act_ && phase_ == Phase::kLift && phase != Phase::kLift) act_->lifted(now_, X_WH_);
  if (act_ && (anew || (phase != Phase::kGrasp && phase != Phase::kLift))) conclude();
  phase_ = phase;
  if (cycle.result().tries() != seen_tries_) {
    seen_tries_ = cycle.result().tries();
    only_feels_ = cycle.result().touches != seen_touches_;
    seen_touches_ = cycle.result().touches;
  }
  if (only_feels_ || (phase != Phase::kGrasp && !act_)) return;
  auto known = moment(percepts);
  if (!known) return;
  now_ = std::move(*known);
  if (phase != Phase::kGrasp) return;
  if (!act_) {
    act_grasp_ = cycle.grasp_index();
    act_tries_ = cycle.result().tries();
    act_.emplace(platform_.hand, cycle.grasp().hand, touch_force_);
  }
  act_->closing(now_);
}

}  // namespace prehend::control
