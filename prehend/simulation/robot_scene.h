#pragma once

#include <string>
#include <vector>

#include "prehend/robot/platform.h"
#include "prehend/simulation/scene.h"

namespace prehend::simulation {

/// A key of a scene that has no effect, why, and what mends it.
struct SceneRemark {
  std::string text;  // "table.yaml:7: carrier.max_speed has no effect: ..."
  /// It is of the gripper in whose place the robot was put, by the node's parameter `robot`.
  bool replaced = false;
};

/// What of a scene's keys means nothing to a robot of arm and hand, for which all others mean what
/// they mean for a gripper: `gripper`, `start_opening` and `carrier`, which the robot replaces, and
/// `tactile` for a hand without pads, are remarked on.
/// @throws geometry::InputError naming key, line and mend for those of `physics` that say that it
/// is simulated in another way than it is. Of a scene made in code the values count.
std::vector<SceneRemark> check_for_robot(const Scene& scene, const robot::Platform& platform);

}  // namespace prehend::simulation
