#pragma once

#include <string>

namespace prehend::planning {
struct Choice;
}

namespace prehend::control {

/// What is worth most by a plan: what `decide` of a task goes by.
struct Advice {
  enum class Act { kGrasp, kTouch, kGiveUp, kProbe };
  Act act = Act::kGrasp;
  int grasp = 0;    // of the plan, that it is touched with; of kProbe: the cycle knows it
  std::string why;  // in words
};

/// Of a plan's best choice. A look is what a cycle does after a failure anyhow: it grasps.
Advice advice_of(const planning::Choice& choice);

}  // namespace prehend::control
