#include "prehend/control/advice.h"

#include "prehend/planning/decision.h"

namespace prehend::control {

Advice advice_of(const planning::Choice& choice) {
  switch (choice.act) {
    case planning::Act::kTouch:
      return {Advice::Act::kTouch, choice.grasp, choice.text};
    case planning::Act::kProbe:
      return {Advice::Act::kProbe, 0, choice.text};
    case planning::Act::kGiveUp:
      return {Advice::Act::kGiveUp, 0, choice.text};
    case planning::Act::kGrasp:
    case planning::Act::kLook:
      break;
  }
  return {Advice::Act::kGrasp, 0, choice.text};
}

}  // namespace prehend::control
