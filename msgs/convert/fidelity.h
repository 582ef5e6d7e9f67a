#pragma once

#include <string>

#include "msgs/objects.pb.h"
#include "prehend/fidelity/front.h"

namespace prehend::convert {

/// What was chosen from a front: the setting's knobs in words, what it cost and its error when the
/// front was measured; `measured` says so in words (fidelity::measured_text()).
msgs::FidelityChoice to_message(const fidelity::Setting& setting, const std::string& measured = "");
/// The same with the front, for who draws it. @param setting one of the front's.
msgs::FidelityChoice to_message(const fidelity::Front& front, const fidelity::Setting& setting,
                                const std::string& measured);

}  // namespace prehend::convert
