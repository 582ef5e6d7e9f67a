#include "eval/platform/graspable_bodies.h"

#include <algorithm>

#include "prehend/geometry/rigid_transform.h"
#include "prehend/planning/platform_plan.h"
#include "prehend/surface/model.h"

namespace prehend::eval {

std::vector<std::string> graspable_bodies(const std::vector<simulation::ClutterSolid>& solids,
                                          const std::vector<simulation::ClutterBody>& bodies,
                                          const robot::Platform& platform) {
  const planning::PlatformPlanner planner(platform);
  planning::PlatformPlanOptions options(platform.hand);
  options.motions = 1;
  options.arm.pick.budget = 0;  // of wall time: plans would not be repeatable
  options.remedies.budget = 0;
  std::vector<std::string> names;
  for (const simulation::ClutterBody& body : bodies) {
    const auto object =
        surface::model_of_mesh(geometry::transformed(*solids[body.solid].mesh_B, body.X_WB));
    const planning::PlatformPlan plan =
        planner.plan(object, {}, {}, {}, platform.home("home").arm, options);
    const bool any = std::any_of(plan.picks.begin(), plan.picks.end(),
                                 [](const auto& pick) { return !pick.segments.empty(); });
    if (any) names.push_back(body.name);
  }
  return names;
}

}  // namespace prehend::eval
