#include "nodes/grasp_planning/made_pushes.h"

#include "msgs/convert/geometry.h"

namespace prehend::nodes {
namespace {

constexpr std::size_t kMost = 256;

}  // namespace

void MadePushes::planned(const msgs::GraspPlan& plan) {
  const Object object{plan.header().stamp(), plan.id()};
  planned_.erase(object);
  if (!plan.has_push() || plan.push().arm_size() == 0) return;
  planned_[object] = {convert::from_message(plan.push().x_wg()).translation(),
                      convert::from_message(plan.push().approach_direction()).normalized()};
  if (planned_.size() > kMost) planned_.erase(planned_.begin());
}

void MadePushes::begun(const msgs::CycleState& state) {
  if (state.phase() != msgs::CycleState::PUSH) return;
  const auto push = planned_.find({state.view_stamp(), state.object_id()});
  if (push == planned_.end()) return;  // said again, of another step of it
  lines_.push_back(push->second);
  planned_.erase(push);
}

void MadePushes::clear() {
  planned_.clear();
  lines_.clear();
}

}  // namespace prehend::nodes
