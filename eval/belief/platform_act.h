#pragma once

#include <string>

#include "eval/grasp/trial_setup.h"
#include "prehend/belief/percepts.h"
#include "prehend/planning/platform_plan.h"
#include "prehend/robot/platform.h"
#include "prehend/simulation/sensors/pad_electronics.h"

namespace prehend::eval {

/// What one attempt of a platform gave.
struct PlatformAct {
  bool closed = false;  // its hand; else it was stopped before, and `why` says by what
  std::string why;
  belief::Percepts percepts;  // of the shipped control::PerceptWatch
  double slide = 0;   // m, of the object in the hand, from when it had closed to after the lift
  double raised = 0;  // m, of the object's lowest point, by the lift
};

/// One attempt with a planned pick on what is there, by the shipped cycle (control::CycleInWorld):
/// reach, approach, close, lift, in the world that the platform has (world_under_test()).
/// @pre the pick has a motion. @throws as world_under_test().
PlatformAct act_once(const robot::Platform& platform, const std::string& home,
                     const planning::PlannedPick& pick, const TrueObject& truth,
                     const simulation::TactileOptions& tactile);

}  // namespace prehend::eval
