#pragma once

#include <vector>

#include <Eigen/Core>

#include "prehend/robot/hand_model.h"

namespace prehend::robot {

/// How motors move fingertips.
struct FingertipWays {
  Eigen::Matrix3Xd ways;    // m for each rad or m, a column a motor
  std::vector<int> finger;  // that a motor moves; -1: none, or several
};

/// Of a hand at `positions` of its motors, in its root frame H. A fingertip is the middle of the
/// shapes of the finger's last link. Motors that move several fingers, as of jaws that are coupled,
/// have zero ways.
FingertipWays fingertip_ways(const HandModel& hand,
                             const Eigen::Ref<const Eigen::VectorXd>& positions);

}  // namespace prehend::robot
