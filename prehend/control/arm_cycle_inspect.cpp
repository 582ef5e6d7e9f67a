// What the cycle of arm and hand does to show what it holds to a camera, or a camera that it
// carries what stands there.

#include <fmt/format.h>

#include "prehend/control/arm_cycle.h"

namespace prehend::control {

bool ArmCycle::inspects() const {
  return step_ == Step::kTurn || step_ == Step::kStill || step_ == Step::kInspect ||
         step_ == Step::kTurnBack;
}

void ArmCycle::begin_inspection() {
  std::string why;
  if (!inspection_) {
    why = "nobody looks at what is held";
  } else if (grasp().views.empty()) {
    why = grasp().views_problem.empty() ? "the plan has no view of what is held"
                                        : grasp().views_problem;
  }
  if (!why.empty()) {
    inspected_ = ", not looked at (" + why + ")";
    return ended(Outcome::kNothing, why);
  }
  view_ = 0;
  views_seen_ = 0;
  view_problem_.clear();
  begin_view();
}

void ArmCycle::begin_view() {
  const JointTrajectory& way = grasp().views[view_];
  enter(Step::kTurn, fmt::format("turning it before the camera, view {} of {}", view_ + 1,
                                 grasp().views.size()));
  if (!way.points.empty()) follow(way, held_collision_force());
}

void ArmCycle::look_at_held() {
  enter(Step::kInspect,
        fmt::format("looking at it, view {} of {}", view_ + 1, grasp().views.size()));
  inspection_->look(gripped_percepts_, percepts_);
}

void ArmCycle::after_look() {
  switch (inspection_->status()) {
    case MotionStatus::kReached:
      ++views_seen_;
      last_found_ = inspection_->found();
      break;
    default:
      view_problem_ = inspection_->found();
  }
  if (grasp().views[view_].points.empty()) return next_view();
  const JointTrajectory way = gone_.back();
  gone_.pop_back();
  enter(Step::kTurnBack, "turning it back");
  follow(reversed(way), held_collision_force(), false);
}

void ArmCycle::next_view() {
  if (++view_ < grasp().views.size()) return begin_view();
  // Turning has loaded the pads otherwise: what they feel now is what is compared from here on.
  if (holds_) hold_slip_.begin(now());
  if (views_seen_ == 0) {
    inspected_ = ", not seen in any view (" + view_problem_ + ")";
    return ended(Outcome::kFailed, "it was not seen in any view: " + view_problem_);
  }
  inspected_ = fmt::format(", seen from {} of {} sides ({})", views_seen_, grasp().views.size(),
                           last_found_);
  achieved(fmt::format("{}: lifted{}", described(grasp(), grasp_index()), inspected_));
  ended(Outcome::kDone);
}

void ArmCycle::go_to_view(const JointTrajectory& way) {
  enter(Step::kToView, "bringing the camera to where it sees another side of it");
  follow(way, options_.collision_force);
}

void ArmCycle::leave_view() {
  if (gone_.empty()) return view_left();  // it could not begin
  enter(Step::kFromView, "bringing the camera back");
  go_back_along();
}

}  // namespace prehend::control
