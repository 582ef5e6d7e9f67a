// What the grasp cycle relies on: it begins when all of it is there, and ends when some is lost.

#include "prehend/control/grasp_cycle.h"

namespace prehend::control {

std::vector<InputAge> GraspCycle::inputs() {
  const auto age = [](bool has_come, double seconds) {
    return has_come ? std::optional(seconds) : std::nullopt;
  };
  const auto pad_age = [](const std::optional<PadPercept>& pad) {
    return pad ? std::optional(pad->age) : std::nullopt;
  };
  const double stale = options_.stale_time;
  return {{"the gripper's state", age(percepts_.opening.has_value(), percepts_.gripper_age), stale},
          {"the left pad's frames", pad_age(percepts_.left), stale},
          {"the right pad's frames", pad_age(percepts_.right), stale},
          {"the wrist's force", age(percepts_.wrist_force.has_value(), percepts_.wrist_age), stale},
          {"the carrier's state", age(percepts_.X_WG.has_value(), percepts_.carrier_age), stale},
          {"the server of the gripper's motion", gripper_port_.answer_age(), options_.answer_time},
          {"the server of the carrier's motion", carrier_port_.answer_age(), options_.answer_time}};
}

void GraspCycle::step_waiting() {
  if (phase_times().empty()) entered(detail_);
  const std::vector<InputAge> missing = stale_inputs(inputs());
  if (missing.empty()) {
    X_WG_start_ = *percepts_.X_WG;
    return begin_task();
  }
  detail_ = "waiting for " + names_of(missing);
  if (timed_out(options_.motion_timeout)) {
    finish(false, "nothing was moved, for want of " + describe(missing));
  }
}

bool GraspCycle::stop_when_lost() {
  const std::vector<InputAge> lost = watch_.lost(now(), inputs());
  if (lost.empty()) return false;
  abort("lost " + describe(lost) + " while " + detail_ + "; gripper and carrier were stopped");
  return true;
}

}  // namespace prehend::control
