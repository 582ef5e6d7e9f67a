#include "prehend/control/hand_sample.h"

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "prehend/touch/hand_touch.h"

namespace prehend::control {

// Joints of a hand that slide are jaws, each half of the opening from the middle.
std::optional<belief::HandSample> hand_sample(const robot::Platform& platform,
                                              const robot::KinematicChain& chain,
                                              const ArmPercepts& percepts) {
  robot::Positions q(chain.size());
  for (int i = 0; i < chain.size(); ++i) {
    const auto found = std::find(percepts.names.begin(), percepts.names.end(),
                                 chain.joints()[static_cast<std::size_t>(i)].name);
    if (found == percepts.names.end()) return std::nullopt;
    q[i] = percepts.positions.at(static_cast<std::size_t>(found - percepts.names.begin()));
  }
  std::vector<std::string> names = percepts.names;
  std::vector<double> positions = percepts.positions;
  if (percepts.gripper) {
    for (const std::string& name : platform.hand.actuated_names()) {
      names.push_back(name);
      positions.push_back(percepts.gripper->opening / 2);
    }
  }
  try {
    return belief::HandSample{platform.X_WB * chain.forward(q) * platform.X_FH,
                              touch::joint_positions(platform.hand, names, positions)};
  } catch (const std::invalid_argument&) {
    return std::nullopt;  // nothing says where the hand's joints are
  }
}

}  // namespace prehend::control
