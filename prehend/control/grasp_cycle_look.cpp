// What the grasp cycle does after a failed attempt: looks again, or takes the next grasp.

#include <utility>

#include "prehend/control/grasp_cycle.h"

namespace prehend::control {

std::optional<double> GraspCycle::looks_since() const {
  return step_ == Step::kLook ? std::optional(entered_) : std::nullopt;
}

void GraspCycle::step_look() {
  if (step_ == Step::kLook) {
    if (timed_out(options_.look_timeout)) next_grasp("no new plan came");
    return;
  }
  const MotionStatus status = carrier_port_.motion();
  if (status == MotionStatus::kMoving && !timed_out(options_.motion_timeout)) return;
  if (status != MotionStatus::kReached) {
    return abort(failure() + "; then the carrier does not get out of the camera's view");
  }
  if (step_ == Step::kGiveUpClear) {
    return enter(Step::kLook, failure() + "; looking again");
  }
  enter(Step::kGiveUpClear, detail_);
  move_carrier(X_WG_start_, options_.travel_speed, 0);
}

void GraspCycle::take_plan(std::vector<grasp::Grasp> grasps, const Eigen::Vector3d& move_W,
                           const std::string& problem) {
  if (step_ != Step::kLook) return;
  if (grasps.empty()) {
    return next_grasp("the new look gives no grasp" + (problem.empty() ? "" : ": " + problem));
  }
  grasps_ = std::move(grasps);
  order_.take(poses_of(grasps_));
  options_.move_W = move_W;
  ++result_.plans;
  begin_grasp(order_.next().value_or(0));
}

// `why` it is not a grasp of a new look, in words; empty: nobody looked.
void GraspCycle::next_grasp(const std::string& why) {
  const std::optional<int> next = order_.next();
  const bool out_of_date = options_.only_seen_again && !why.empty();
  if (!next || out_of_date || result_.attempts >= options_.largest_attempts) {
    return finish(false, failed_attempts().text() + (why.empty() ? "" : "; " + why));
  }
  begin_grasp(*next);
  if (!why.empty()) detail_ = why + ": the next grasp of the plan before; " + detail_;
}

}  // namespace prehend::control
