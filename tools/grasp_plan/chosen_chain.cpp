#include "tools/grasp_plan/chosen_chain.h"

#include <filesystem>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/geometry/errors.h"

namespace prehend::tools {
namespace {

// As the launch files have it.
const char* front_of(const PlanChoices& choices) {
  const bool is_gripper =
      choices.platform.empty() ? choices.hand == "pg70" : choices.platform == "stage_pg70";
  return is_gripper ? "chain.yaml" : "chain_hand.yaml";
}

}  // namespace

std::optional<ChosenChain> chosen_chain(const PlanChoices& choices) {
  const auto budget = choices.grasp_knobs.find("budget");
  const double seconds = budget == choices.grasp_knobs.end() ? 0 : budget->second;
  if (!(seconds > 0) && !(choices.tolerance > 0)) return std::nullopt;
  const char* chosen = choices.alternatives          ? "--alternatives"
                       : !choices.generators.empty() ? "--generators"
                       : choices.grasp_knobs.count("robustness_samples") > 0
                           ? "--robustness-samples"
                           : nullptr;
  if (chosen != nullptr) {
    throw geometry::InputError(
        std::string(chosen) + " is chosen for a cloud where --budget or --tolerance is given",
        "Leave one of them out");
  }
  ChosenChain chain;
  chain.front =
      fidelity::read_front(std::filesystem::path(choices.config) / "fidelity" / front_of(choices));
  chain.setting = fidelity::choose_for_stage(chain.front, seconds, choices.tolerance);
  return chain;
}

}  // namespace prehend::tools
