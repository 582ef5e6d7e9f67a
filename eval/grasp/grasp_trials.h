#pragma once

#include <functional>
#include <string>
#include <vector>

#include "eval/data_sets.h"
#include "eval/grasp/grasp_case.h"
#include "prehend/grasp/planner.h"
#include "prehend/surface/object_model.h"

namespace prehend::eval {

/// A way to plan.
struct PlannerSetting {
  std::string name;
  PlannedOn planned_on = PlannedOn::kPredicted;
  grasp::PlannerOptions options;
};

/// The planner's defaults on the prediction, on the truth and on the Delaunay surface.
std::vector<PlannerSetting> compared_settings();

/// An object as a hand meets it: in the world, on the table z = 0.
struct TrueObject {
  geometry::TriangleMesh mesh_W;
  double mass = 0;  // kg
};

/// A hand under test: plans on what is believed by `setting`, and executes on what is there.
struct HandUnderTest {
  std::string name;
  std::function<GraspTrial(const surface::ObjectModel& believed, const TrueObject& truth,
                           const PlannerSetting& setting)>
      grasp;
};

/// The parallel gripper on the carrier that approaches from above, by the whole grasp cycle with
/// its three attempts. `lifted` is by 100 mm at least.
HandUnderTest parallel_gripper();

/// Renders the case's stereo pair, segments it, predicts the object and tries each setting.
/// What fails is in the result's problems; only a bug throws.
GraspCase run_grasp_case(const Case& one, const HandUnderTest& hand,
                         const std::vector<PlannerSetting>& settings);

}  // namespace prehend::eval
