#pragma once

#include <filesystem>
#include <string>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/front.h"

namespace prehend::fidelity {

/// The front of whole chains, and the setting of it that a budget or tolerance chose.
struct ChosenChain {
  Front front;
  Setting setting;
  double budget = 0;     // s of processor, that was asked for; 0: none
  double tolerance = 0;  // m, the same
};

/// The file of measured chains from that input for a hand alone or, where it is not empty, for the
/// platform: the PG70's on its stage, or the one for all others. As the launch files have it.
std::string chain_front_name(ChainInput input, const std::string& hand,
                             const std::string& platform = "");

/// Of that file in `folder` (config/fidelity), as choose_for_stage().
/// @throws geometry::InputError as that, and for a file that is no front of chains.
ChosenChain choose_chain(const std::filesystem::path& folder, const std::string& front_name,
                         double budget, double tolerance);

/// Whether a setting of the front chooses this knob.
bool has_knob(const Front& front, const std::string& name);

}  // namespace prehend::fidelity
