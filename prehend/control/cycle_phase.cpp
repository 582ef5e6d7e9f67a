#include "prehend/control/grasp_cycle.h"

namespace prehend::control {

Phase GraspCycle::phase_of(Step step) {
  switch (step) {
    case Step::kWaiting:
    case Step::kLook:
      return Phase::kWaiting;
    case Step::kOpen:
    case Step::kRise:
    case Step::kCross:
    case Step::kPregrasp:
    case Step::kApproach:
      return Phase::kApproach;
    case Step::kClose:
    case Step::kPress:
      return Phase::kGrasp;
    case Step::kLift:
    case Step::kCheck:
      return Phase::kLift;
    case Step::kMove:
    case Step::kLower:
      return Phase::kMove;
    case Step::kRelease:
    case Step::kRetreat:
    case Step::kGiveUpOpen:
    case Step::kGiveUpRetreat:
    case Step::kGiveUpRise:
    case Step::kGiveUpClear:
      return Phase::kRelease;
    case Step::kDone:
      return Phase::kDone;
    case Step::kFailed:
      return Phase::kFailed;
  }
  return Phase::kFailed;
}

}  // namespace prehend::control
