#pragma once

#include <vector>

#include "eval/data_sets.h"
#include "eval/grasp/platform_under_test.h"
#include "prehend/belief/attempt_memory.h"

namespace prehend::eval {

/// The planner's defaults on the prediction, on the truth and on the Delaunay surface.
std::vector<PlannerSetting> compared_settings();

/// What attempts found out is used as `evidence` says when the object is seen again.
///
/// Lets the case's object come to rest (resting_pose) among the other bodies of the case, renders
/// its stereo pair, segments it, predicts the object and tries each setting. What fails is in the
/// result's problems; only a bug throws.
GraspCase run_grasp_case(const Case& one, const PlatformUnderTest& platform,
                         const std::vector<PlannerSetting>& settings,
                         belief::EvidenceUse evidence = belief::EvidenceUse::kLooks);

}  // namespace prehend::eval
