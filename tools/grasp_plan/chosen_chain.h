#pragma once

#include <optional>

#include "prehend/fidelity/chosen_chain.h"
#include "prehend/report/front_chart.h"
#include "tools/grasp_plan/choices.h"
#include "tools/json.h"

namespace prehend::tools {

/// What --budget or --tolerance choose for a cloud; none where neither is given.
/// @throws geometry::InputError as fidelity::choose_chain(), and for an option that the front sets.
std::optional<fidelity::ChosenChain> chosen_chain(const PlanChoices& choices);

/// The front with the setting chosen, to be drawn.
report::DrawnFront drawn_front(const fidelity::ChosenChain& chain);

/// What was asked for, chosen and measured, for programs.
Json chain_json(const fidelity::ChosenChain& chain);

}  // namespace prehend::tools
