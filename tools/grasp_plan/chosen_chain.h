#pragma once

#include <optional>

#include "prehend/fidelity/front.h"
#include "prehend/report/front_chart.h"
#include "tools/grasp_plan/choices.h"
#include "tools/json.h"

namespace prehend::tools {

/// The front of whole chains and the setting of it that --budget or --tolerance choose for a cloud.
struct ChosenChain {
  fidelity::Front front;
  fidelity::Setting setting;
  double budget = 0;     // s, that was asked for; 0: none
  double tolerance = 0;  // m, the same
};

/// None where neither is given. @throws geometry::InputError as fidelity::choose_for_stage(), for a
/// front that cannot be read, and for an option that the front sets.
std::optional<ChosenChain> chosen_chain(const PlanChoices& choices);

/// The front with the setting chosen, to be drawn.
report::DrawnFront drawn_front(const ChosenChain& chain);

/// What was asked for, chosen and measured, for programs.
Json json_of(const ChosenChain& chain);

}  // namespace prehend::tools
