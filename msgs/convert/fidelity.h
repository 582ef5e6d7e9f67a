#pragma once

#include "msgs/objects.pb.h"
#include "prehend/fidelity/front.h"

namespace prehend::convert {

/// What was chosen from a front: the setting's knobs in words, what it cost and its error when the
/// front was measured.
msgs::FidelityChoice to_message(const fidelity::Setting& setting);

}  // namespace prehend::convert
