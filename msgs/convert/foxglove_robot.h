#pragma once

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "foxglove/FrameTransforms.pb.h"
#include "foxglove/SceneUpdate.pb.h"
#include "msgs/geometry.pb.h"
#include "prehend/robot/platform.h"

namespace prehend::convert {

/// Entities `robot/<link>`, each in its link's frame and locked to it: the link's collision shapes.
/// Links of the arm are grey, those of the hand darker; links without shapes have none.
::foxglove::SceneUpdate robot_update(const robot::Platform& platform, std::int64_t stamp);

/// Poses X_WL of all links of the platform's model, in their order.
/// @param positions [rad or m] of joints, by the platform's names of them (arm_..., hand_...).
/// Mimics follow their leader; other joints that are not named stand at 0, or at the limit nearest
/// to it.
std::vector<geometry::RigidTransform> link_poses(const robot::Platform& platform,
                                                 const std::map<std::string, double>& positions);

/// Adds frame `child` at `X_PC` in `parent`.
void add_transform(::foxglove::FrameTransforms& transforms, std::int64_t stamp,
                   const std::string& parent, const std::string& child,
                   const geometry::RigidTransform& X_PC);

}  // namespace prehend::convert
