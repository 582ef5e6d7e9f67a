#pragma once

#include <optional>
#include <vector>

#include "prehend/robot/kinematic_chain.h"

namespace prehend::motion {

/// The chain's joint that moves a link, and where the link's frame is in that joint's frame.
struct LinkPlace {
  int joint = -1;  // stands with the base
  geometry::RigidTransform X_JL = geometry::RigidTransform::Identity();
};

/// Of every link of `model`; none for what is not below the link `base`. Joints beside the chain
/// are in the middle of their limits, or at 0.
std::vector<std::optional<LinkPlace>> link_places(const robot::RobotModel& model,
                                                  const robot::KinematicChain& chain, int base);

}  // namespace prehend::motion
