#include "nodes/grasp_planning/made_pushes.h"

#include "msgs/convert/geometry.h"

namespace prehend::nodes {

void MadePushes::planned(const msgs::GraspPlan& plan) {
  planned_.erase(plan.id());
  if (!plan.has_push() || plan.push().arm_size() == 0) return;
  planned_[plan.id()] = {convert::from_message(plan.push().x_wg()).translation(),
                         convert::from_message(plan.push().approach_direction()).normalized()};
}

void MadePushes::begun(const msgs::CycleState& state) {
  if (state.phase() != msgs::CycleState::PUSH) return;
  const auto push = planned_.find(state.object_id());
  if (push == planned_.end()) return;  // said again, of another step of it
  lines_.push_back(push->second);
  planned_.erase(push);
}

void MadePushes::clear() {
  planned_.clear();
  lines_.clear();
}

}  // namespace prehend::nodes
