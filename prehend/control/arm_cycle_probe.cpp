// What the cycle of arm and hand does with what is no grasp: a probe of one fingertip, and a push.

#include <algorithm>

#include "prehend/control/arm_cycle.h"

namespace prehend::control {

std::optional<int> ArmCycle::probe_grasp() const {
  const auto probe = std::find_if(grasps_.begin(), grasps_.end(),
                                  [](const ArmGrasp& one) { return one.probe_H.has_value(); });
  if (probe == grasps_.end()) return std::nullopt;
  return static_cast<int>(probe - grasps_.begin());
}

std::optional<int> ArmCycle::push_grasp() const {
  const auto push =
      std::find_if(grasps_.begin(), grasps_.end(), [](const ArmGrasp& one) { return one.pushes; });
  if (push == grasps_.end()) return std::nullopt;
  return static_cast<int>(push - grasps_.begin());
}

std::optional<Eigen::Vector3d> ArmCycle::met_with_H() const {
  return step_ == Step::kMet && !finished() ? grasp().probe_H : std::nullopt;
}

bool ArmCycle::pads_meet() const {
  return std::any_of(percepts_.pads.begin(), percepts_.pads.end(), [this](const PadPercept& pad) {
    const auto rest = sums_at_rest_.find(pad.name);
    return rest != sums_at_rest_.end() && pad.sum - rest->second > options_.touch_force;
  });
}

}  // namespace prehend::control
