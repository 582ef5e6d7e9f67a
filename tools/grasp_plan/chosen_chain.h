#pragma once

#include <optional>

#include "prehend/fidelity/front.h"
#include "tools/grasp_plan/choices.h"

namespace prehend::tools {

/// The front of whole chains and the setting of it that --budget or --tolerance choose for a cloud.
struct ChosenChain {
  fidelity::Front front;
  fidelity::Setting setting;
};

/// None where neither is given. @throws geometry::InputError as fidelity::choose_for_stage(), for a
/// front that cannot be read, and for an option that the front sets.
std::optional<ChosenChain> chosen_chain(const PlanChoices& choices);

}  // namespace prehend::tools
