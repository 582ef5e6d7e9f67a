#include "prehend/robot/formats/extension_parts.h"

namespace prehend::robot::formats {

std::string merge_joint(RobotDescription& robot, const std::string& name) {
  const JointDescription* found = robot.joint(name);
  if (!found || found->kind != JointDescription::Kind::kFixed) return "is no fixed joint";
  const JointDescription fixed = *found;
  const LinkDescription* between = robot.link(fixed.parent);
  if (!between || between->inertial || !between->visuals.empty() || !between->collisions.empty()) {
    return "hangs on a link that is more than a frame";
  }
  JointDescription* above = nullptr;
  for (JointDescription& joint : robot.joints) {
    if (joint.child == fixed.parent) above = &joint;
    if (joint.parent == fixed.parent && joint.name != name) return "is not alone on its link";
  }
  if (!above) return "has no joint above it";
  above->X_JC = above->X_JC * fixed.X_PJ * fixed.X_JC;
  above->child = fixed.child;
  std::erase_if(robot.joints, [&](const auto& joint) { return joint.name == name; });
  std::erase_if(robot.links, [&](const auto& link) { return link.name == fixed.parent; });
  return {};
}

}  // namespace prehend::robot::formats
