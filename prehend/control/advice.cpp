#include "prehend/control/advice.h"

#include "prehend/planning/decision.h"

namespace prehend::control {

Advice advice_of(const planning::Choice& choice, const JointTrajectory& look) {
  const auto to = [&](Advice::Act act, int grasp = 0) {
    return Advice{act, grasp, choice.text, look};
  };
  switch (choice.act) {
    case planning::Act::kTouch:
      return to(Advice::Act::kTouch, choice.grasp);
    case planning::Act::kProbe:
      return to(Advice::Act::kProbe);
    case planning::Act::kGiveUp:
      return to(Advice::Act::kGiveUp);
    case planning::Act::kLook:
      if (!look.points.empty()) return to(Advice::Act::kLook);
      break;
    case planning::Act::kGrasp:
      break;
  }
  return to(Advice::Act::kGrasp);
}

}  // namespace prehend::control
