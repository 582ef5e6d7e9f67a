#pragma once

#include <string>

#include "prehend/fidelity/front.h"
#include "prehend/grasp/planner.h"

namespace prehend::fidelity {

/// Sets the planner's options that a setting of the front "plan" chooses; all others stay as they
/// are. Knobs (all optional; absent: as it is):
///   generators  names joined by +, as in circles+boxes
///   further     generators tried as well where nothing is robust, or none
///   rolls       over half a turn, of circles
///   standoffs   depths of the fingertips, of circles
///   offsets     positions across the fingers 15 mm apart, an odd number, of circles
///   samples     disturbed poses and frictions in which each listed grasp is tried
///   count       grasps that are listed, so tried
///   enough      of these that are sure to hold: then no more candidates are tried; 0: all are
///   first_share one of so many candidates is tried before it is asked whether these are enough
/// @throws geometry::InputError naming a knob that is unknown or has a value it cannot have.
void apply_plan_setting(const Setting& setting, grasp::PlannerOptions* options);

struct ChosenPlan {
  Setting setting;   // of the front, with the knobs of all of its stages
  std::string text;  // the plan's, and what was measured, in words
};

/// Applies the setting of the front, of plans or of the whole chain, with the fewest failures
/// within `budget` [s], or, when none is, the fastest one; and sets the planner's budget, which
/// ends planning in any case: of a chain what the stages before have left of it. With a `tolerance`
/// [m] instead, of a chain's meshes, planning takes what it takes. Returns what was chosen.
/// @throws geometry::InputError as apply_plan_setting, for both or another front, and for a
/// tolerance that the front cannot keep; std::invalid_argument as within_budget.
ChosenPlan apply_plan_front(const Front& front, double budget, double tolerance,
                            grasp::PlannerOptions* options);

}  // namespace prehend::fidelity
