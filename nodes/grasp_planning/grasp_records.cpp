#include "nodes/grasp_planning/grasp_records.h"

#include <utility>

#include <fmt/format.h>

#include "msgs/convert/geometry.h"
#include "msgs/convert/grasp.h"
#include "msgs/convert/outcomes.h"

namespace prehend::nodes {

std::optional<grasp::PlacedObject> GraspRecords::known(const msgs::ObjectModel& model) {
  if (!model.has_known()) return std::nullopt;
  return convert::from_message(model.known());
}

void GraspRecords::planned(const msgs::ObjectModel& model, const msgs::GraspPlan& plan) {
  plans_.erase(model.id());
  const auto placed = known(model);
  if (!placed) return;
  Plan planned{*placed, {}};
  for (const auto& grasp : plan.grasps()) {
    planned.X_WG.push_back(convert::from_message(grasp.x_wg()));
  }
  plans_[model.id()] = std::move(planned);
}

std::string GraspRecords::record(const msgs::CycleResult& result, const std::string& hand) {
  const auto plan = plans_.find(result.object_id());
  if (result.attempts() == 0 || plan == plans_.end() ||
      result.grasp_index() >= plan->second.X_WG.size()) {
    return "";
  }
  const auto& [placed, poses] = plan->second;
  const bool held = convert::from_message(result.outcome()) == control::CycleOutcome::kSucceeded;
  if (!grasp::remember_execution(database_, placed, hand, poses[result.grasp_index()], held)) {
    return "";
  }
  return fmt::format("recorded: grasp {} of {} {}", result.grasp_index(), placed.name,
                     held ? "held" : "did not hold");
}

}  // namespace prehend::nodes
