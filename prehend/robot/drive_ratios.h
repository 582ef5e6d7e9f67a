#pragma once

#include <vector>

#include "prehend/robot/hand_model.h"

namespace prehend::robot {

/// The motor behind each joint of a hand, over chains of mimics (-1: fixed), and how far the joint
/// moves for each unit of the motor's.
struct DriveRatios {
  explicit DriveRatios(const HandModel& hand);
  std::vector<int> motor;
  std::vector<double> ratio;
};

}  // namespace prehend::robot
