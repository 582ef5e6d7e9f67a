#include "prehend/fidelity/chosen_chain.h"

#include "prehend/fidelity/chain_settings.h"
#include "prehend/geometry/errors.h"

namespace prehend::fidelity {

const char* chain_front_name(const std::string& hand, const std::string& platform) {
  const bool is_measured = platform.empty() ? hand == "pg70" : platform == "stage_pg70";
  return is_measured ? "chain.yaml" : "chain_hand.yaml";
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

}  // namespace prehend::fidelity
