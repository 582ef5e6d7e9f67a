#include "tools/grasp_plan/chosen_chain.h"

#include <algorithm>
#include <filesystem>
#include <string>
#include <utility>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/geometry/errors.h"

namespace prehend::tools {
namespace {

[[noreturn]] void refuse(std::string option) {
  std::replace(option.begin(), option.end(), '_', '-');
  throw geometry::InputError(
      option + " is chosen for a cloud where --budget or --tolerance is given",
      "Leave one of them out");
}

}  // namespace

std::optional<fidelity::ChosenChain> chosen_chain(const PlanChoices& choices) {
  const auto budget = choices.grasp_knobs.find("budget");
  const double seconds = budget == choices.grasp_knobs.end() ? 0 : budget->second;
  if (!(seconds > 0) && !(choices.tolerance > 0)) return std::nullopt;
  const char* chosen = choices.alternatives          ? "--alternatives"
                       : !choices.generators.empty() ? "--generators"
                       : choices.grasp_knobs.count("robustness_samples") > 0
                           ? "--robustness-samples"
                           : nullptr;
  if (chosen != nullptr) refuse(chosen);
  fidelity::ChosenChain chain = fidelity::choose_chain(
      std::filesystem::path(choices.config) / "fidelity",
      fidelity::chain_front_name(fidelity::ChainInput::kCloud, choices.hand, choices.platform),
      seconds, choices.tolerance);
  for (const auto& [option, knob] :
       {std::pair("largest_count", "plan.count"), std::pair("enough_grasps", "plan.enough"),
        std::pair("first_share", "plan.first_share")}) {
    if (choices.grasp_knobs.count(option) == 0 || !fidelity::has_knob(chain.front, knob)) continue;
    refuse("--" + std::string(option));
  }
  return chain;
}

report::DrawnFront drawn_front(const fidelity::ChosenChain& chain) {
  report::DrawnFront drawn;
  drawn.subject = chain.front.subject;
  drawn.error_name = chain.front.error_name;
  drawn.error_unit = chain.front.error_unit;
  for (const fidelity::Setting& one : chain.front.settings) {
    if (one.knobs == chain.setting.knobs) drawn.chosen = drawn.points.size();
    drawn.points.push_back({one.seconds, one.error, fidelity::tolerated_error(chain.front, one)});
  }
  drawn.budget = chain.budget;
  drawn.tolerance = chain.tolerance;
  drawn.measured = fidelity::measured_text(chain.front, chain.setting);
  drawn.knobs = to_string(chain.setting);
  return drawn;
}

Json chain_json(const fidelity::ChosenChain& chain) {
  Json knobs = Json::object();
  for (const auto& [name, value] : chain.setting.knobs) knobs.set(name, value);
  return Json::object()
      .set("budget_s", chain.budget)
      .set("tolerance_m", chain.tolerance)
      .set("measured_s", chain.setting.seconds)
      .set("measured_share_not_lifted", chain.setting.error)
      .set("measured_mesh_error_m", fidelity::tolerated_error(chain.front, chain.setting))
      .set("knobs", knobs);
}

}  // namespace prehend::tools
