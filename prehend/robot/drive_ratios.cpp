#include "prehend/robot/drive_ratios.h"

#include <algorithm>

namespace prehend::robot {

DriveRatios::DriveRatios(const HandModel& hand)
    : motor(hand.model.joints.size(), -1), ratio(hand.model.joints.size(), 1) {
  for (std::size_t j = 0; j < hand.model.joints.size(); ++j) {
    int joint = static_cast<int>(j);
    while (hand.model.joints[static_cast<std::size_t>(joint)].mimic) {
      ratio[j] *= hand.model.joints[static_cast<std::size_t>(joint)].mimic->multiplier;
      joint = hand.model.joints[static_cast<std::size_t>(joint)].mimic->joint;
    }
    const auto found = std::find(hand.actuated.begin(), hand.actuated.end(), joint);
    if (found != hand.actuated.end()) motor[j] = static_cast<int>(found - hand.actuated.begin());
  }
}

}  // namespace prehend::robot
