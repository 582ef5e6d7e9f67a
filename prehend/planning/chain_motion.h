#pragma once

#include "prehend/fidelity/front.h"
#include "prehend/planning/platform_plan.h"

namespace prehend::planning {

/// Sets what a chain's setting chooses of what comes after the hand's grasps; all else stays as it
/// is, and everything by a front of plans alone. Knobs (all optional; absent: as it is):
///   motion.grasps    how many get the arm's motion, > 0
///   simulation.step  s, in (0, 1), of the hand that closes in simulation to tell what its pads
///                    will feel; none: it does not, and nothing that is felt is a surprise.
///                    Nothing where `options` predict no touch
/// @throws geometry::InputError naming a knob that is unknown or has a value it cannot have.
void apply_motion_setting(const fidelity::Front& front, const fidelity::Setting& setting,
                          PlatformPlanOptions* options);

}  // namespace prehend::planning
