#pragma once

#include <algorithm>
#include <string>
#include <utility>

#include "prehend/control/cycle_in_world.h"
#include "prehend/control/planned_grasp.h"
#include "prehend/robot/platform.h"
#include "prehend/surface/model.h"

// What a platform's planner plans on, made ready for the cycle that ships.
namespace prehend::control {

class PickOf {
 public:
  /// A platform of config/robots at its home `side`. Tests run in the project's folder.
  explicit PickOf(const std::string& name)
      : planner(robot::read_platform("config/robots/" + name + ".yaml")) {}

  const robot::Platform& platform() const { return planner.platform(); }

  planning::PlatformPlanOptions plan_options() const {
    planning::PlatformPlanOptions options(platform().hand);
    options.grasps.threads = 1;
    options.touch.emplace().threads = 1;
    options.arm.pick.budget = 0;  // of wall time: plans would not be repeatable
    return options;
  }

  planning::PlatformPlan plan(const geometry::TriangleMesh& mesh_W) const {
    return planner.plan(surface::model_of_mesh(mesh_W), {}, {}, {}, start, plan_options());
  }

  GraspsToTry to_try(const planning::PlatformPlan& plan) const {
    GraspsToTry grasps{{}, grasp::in_words(plan)};
    for (const planning::PlannedPick& pick : plan.picks) {
      if (!pick.segments.empty()) grasps.grasps.push_back(arm_grasp(platform(), pick));
    }
    return grasps;
  }

  const planning::PlatformPlanner planner;
  const robot::Positions start = planner.platform().home("side").arm;
};

inline ArmCycleOptions reacting() {
  ArmCycleOptions options;
  options.reacts = true;
  return options;
}

}  // namespace prehend::control
