#pragma once

#include <optional>
#include <string>

#include "prehend/control/joint_trajectory.h"

namespace prehend::planning {
struct Choice;
}

namespace prehend::control {

/// What is worth most by a plan: what `decide` of a task goes by.
struct Advice {
  enum class Act { kGrasp, kTouch, kGiveUp, kProbe, kLook };
  Act act = Act::kGrasp;
  int grasp = 0;              // of the plan, that it is touched with; of kProbe: the cycle knows it
  std::string why;            // in words
  JointTrajectory look = {};  // the way to where it is looked from; without points: there is none
  std::optional<int> first = {};  // of the plan, that is tried before all others
};

/// Of a plan's best choice. @param look of the plan; without points: there is no way to it, and the
/// cycle grasps.
Advice advice_of(const planning::Choice& choice, const JointTrajectory& look = {});

}  // namespace prehend::control
