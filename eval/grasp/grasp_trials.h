#pragma once

#include <optional>
#include <string>
#include <vector>

#include "eval/data_sets.h"
#include "eval/grasp/platform_under_test.h"
#include "prehend/belief/attempt_memory.h"
#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/chosen_chain.h"
#include "prehend/fidelity/shape_settings.h"

namespace prehend::eval {

/// The planner's defaults on those of the prediction, the truth and the Delaunay surface whose
/// names, to_string(), are in `executed`; on the truth, which tells whether an object fits, in any
/// case.
std::vector<PlannerSetting> compared_settings(const std::vector<std::string>& executed);

/// How views are seen, shapes predicted and grasps planned on what is not the truth: the defaults,
/// or as a chain's setting says.
struct ChainOptions {
  fidelity::SeeingOptions seeing;
  fidelity::ShapeOptions shape;
  PlanChange plan;
};
/// Those of a chain that was chosen; before one that begins with a cloud the defaults see it.
/// @throws geometry::InputError for knobs that are unknown.
ChainOptions chain_options(const fidelity::ChosenChain& chain);

/// What attempts found out is used as `evidence` says when the object is seen again.
///
/// Lets the case's object come to rest (resting_pose) among the other bodies of the case, renders
/// its stereo pair, segments it, predicts the object and tries each setting. What fails is in the
/// result's problems; only a bug throws.
GraspCase run_grasp_case(const Case& one, const PlatformUnderTest& platform,
                         const std::vector<PlannerSetting>& settings,
                         belief::EvidenceUse evidence = belief::EvidenceUse::kLooks,
                         const ChainOptions& chain = {});

}  // namespace prehend::eval
