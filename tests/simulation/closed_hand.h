#pragma once

#include <algorithm>
#include <string>

#include "prehend/robot/hand_model.h"

namespace prehend::simulation {

/// Positions that the closing joints of `preshape` run towards, as far as their limits let them.
inline Eigen::VectorXd closed(const robot::HandModel& hand, const std::string& preshape,
                              double way) {
  const robot::Preshape& shape = hand.preshape(preshape);
  Eigen::VectorXd q = shape.open;
  for (int i = 0; i < hand.size(); ++i) {
    const robot::Joint& joint =
        hand.model.joints[static_cast<std::size_t>(hand.actuated[static_cast<std::size_t>(i)])];
    q[i] = std::clamp(q[i] + way * shape.closing[static_cast<std::size_t>(i)].rate, joint.lower,
                      joint.upper);
  }
  return q;
}

}  // namespace prehend::simulation
