#include "prehend/fidelity/chosen_chain.h"

#include <algorithm>

#include "prehend/geometry/errors.h"

namespace prehend::fidelity {

std::string chain_front_name(ChainInput input, const std::string& hand,
                             const std::string& platform) {
  const bool is_measured = platform.empty() ? hand == "pg70" : platform == "stage_pg70";
  return std::string("chain") + (input == ChainInput::kCloud ? "_cloud" : "") +
         (is_measured ? "" : "_hand") + ".yaml";
}

ChosenChain choose_chain(const std::filesystem::path& folder, const std::string& front_name,
                         double budget, double tolerance) {
  const std::filesystem::path file = folder / front_name;
  ChosenChain chosen{read_front(file), {}, budget, tolerance};
  if (chosen.front.subject != "chain") {
    throw geometry::InputError(
        "'" + file.string() + "' is a front of '" + chosen.front.subject + "', not of whole chains",
        "Name the folder config/fidelity, or measure: eval_tradeoff chain");
  }
  chosen.setting = choose_for_stage(chosen.front, budget, tolerance);
  return chosen;
}

bool has_knob(const Front& front, const std::string& name) {
  return std::any_of(front.settings.begin(), front.settings.end(), [&](const Setting& setting) {
    return std::any_of(setting.knobs.begin(), setting.knobs.end(),
                       [&](const auto& knob) { return knob.first == name; });
  });
}

}  // namespace prehend::fidelity
