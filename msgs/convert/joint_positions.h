#pragma once

#include <optional>

#include "msgs/joints.pb.h"
#include "prehend/robot/kinematic_chain.h"

namespace prehend::convert {

/// Where a chain's joints are [rad or m], by their names in the platform's model, among whatever
/// other joints the message has. None: one is missing or not finite.
std::optional<robot::Positions> positions_of(const robot::KinematicChain& chain,
                                             const msgs::JointState& joints);

}  // namespace prehend::convert
