#include "prehend/motion/link_places.h"

#include <algorithm>
#include <cmath>

namespace prehend::motion {
namespace {

double resting_position(const robot::Joint& joint) {
  const double middle = 0.5 * (joint.lower + joint.upper);
  return std::isfinite(middle) ? middle : 0;
}

}  // namespace

std::vector<std::optional<LinkPlace>> link_places(const robot::RobotModel& model,
                                                  const robot::KinematicChain& chain, int base) {
  std::vector<std::optional<LinkPlace>> result(model.links.size());
  result[static_cast<std::size_t>(base)] = LinkPlace{};
  for (const robot::Joint& joint : model.joints) {
    const auto& parent = result[static_cast<std::size_t>(joint.parent)];
    if (!parent) continue;  // not below the base
    LinkPlace place;
    const auto moving =
        std::find_if(chain.joints().begin(), chain.joints().end(),
                     [&](const robot::ChainJoint& j) { return j.name == joint.name; });
    if (moving != chain.joints().end()) {
      place.joint = static_cast<int>(moving - chain.joints().begin());
    } else {
      place.joint = parent->joint;
      place.X_JL = parent->X_JL * joint.pose_at(resting_position(joint));
    }
    result[static_cast<std::size_t>(joint.child)] = place;
  }
  return result;
}

}  // namespace prehend::motion
