// Before a new look the gripper gets out of the camera's view.

#include "prehend/control/grasp_cycle.h"

namespace prehend::control {

void GraspCycle::clear_view() {
  enter(Step::kRiseClear, (failure().empty() ? "" : failure() + "; ") +
                              std::string("getting out of the camera's view"));
  move_carrier(raised_to_transit(percepts_.X_WG.value_or(X_WG_target_)), options_.travel_speed, 0);
}

void GraspCycle::step_clear() {
  const MotionStatus status = carrier_port_.motion();
  if (status == MotionStatus::kMoving && !timed_out(options_.motion_timeout)) return;
  if (status != MotionStatus::kReached) {
    return abort(failure() + "; then the carrier does not get out of the camera's view");
  }
  if (step_ == Step::kClear) return look_now();
  enter(Step::kClear, detail_);
  move_carrier(X_WG_start_, options_.travel_speed, 0);
}

}  // namespace prehend::control
