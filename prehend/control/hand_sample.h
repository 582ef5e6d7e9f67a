#pragma once

#include <optional>

#include "prehend/belief/hand_evidence.h"
#include "prehend/control/arm_cycle.h"
#include "prehend/robot/kinematic_chain.h"
#include "prehend/robot/platform.h"

namespace prehend::control {

/// Where the platform's hand and its joints are by these percepts; none where they do not say it.
/// @param chain the platform's arm_chain()
std::optional<belief::HandSample> hand_sample(const robot::Platform& platform,
                                              const robot::KinematicChain& chain,
                                              const ArmPercepts& percepts);

}  // namespace prehend::control
