#include "msgs/convert/joint_positions.h"

#include <algorithm>
#include <cmath>
#include <string>

namespace prehend::convert {

std::optional<robot::Positions> positions_of(const robot::KinematicChain& chain,
                                             const msgs::JointState& joints) {
  robot::Positions positions(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const std::string& name = chain.joints()[static_cast<std::size_t>(i)].name;
    const auto found = std::find(joints.name().begin(), joints.name().end(), name);
    const int k = static_cast<int>(found - joints.name().begin());
    if (k >= joints.position_size() || !std::isfinite(joints.position(k))) return std::nullopt;
    positions[i] = joints.position(k);
  }
  return positions;
}

}  // namespace prehend::convert
