#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prehend/grasp/known/grasp_memory.h"
#include "prehend/planning/decision.h"
#include "prehend/planning/platform_pick.h"
#include "prehend/planning/remedies.h"
#include "tools/grasp_plan/target.h"

namespace prehend::tools {

struct Planned {
  robot::HandModel hand;
  std::optional<robot::Platform> platform;
  grasp::GraspPlan plan;
  grasp::Remembered remembered;  // what the database had to do with it
  std::string chosen;            // by the budget from the measured front, in words
  std::optional<planning::PlatformPick> arm;
  std::vector<planning::Choice> choices;  // what may be done with it, best first
  planning::Remedies remedies;            // where there is no grasp, or no motion
  StageTimes times;
};

/// Plans the grasps and, with an arm, its motion; `progress` is told the stages.
/// @throws geometry::InputError naming what is wrong and the mend; std::invalid_argument.
Planned make_plan(const PlanChoices& choices, const PlanTarget& target, Progress& progress);

}  // namespace prehend::tools
