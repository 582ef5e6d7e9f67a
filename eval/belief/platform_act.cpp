#include "eval/belief/platform_act.h"

#include <algorithm>
#include <optional>

#include "eval/grasp/world_under_test.h"
#include "prehend/control/cycle_in_world.h"
#include "prehend/control/percept_watch.h"
#include "prehend/control/planned_grasp.h"

namespace prehend::eval {
namespace {

// As config/tasks/pick_and_place.yaml begins.
const control::Task& lift_only() {
  static const control::Task task = control::parse_task(R"(
description: pick one object
start: look
states:
  look: {do: look, done: approach, otherwise: failure}
  approach: {do: approach, done: grasp, failed: failure}
  grasp: {do: grasp, done: lift, failed: failure}
  lift: {do: lift, done: success, otherwise: failure}
)",
                                                        "lift_only.yaml");
  return task;
}

}  // namespace

PlatformAct act_once(const robot::Platform& platform, const std::string& home,
                     const planning::PlannedPick& pick, const TrueObject& truth,
                     const simulation::TactileOptions& tactile) {
  const auto world = world_under_test(platform, home, truth, tactile);
  control::ArmCycleOptions options;
  options.reacts = true;  // as launch files have it
  options.task = lift_only();
  options.largest_attempts = 1;
  control::CycleInWorld cycle(world->robot(), options);
  control::PerceptWatch watch(platform);
  const ObjectReading start = world->object();
  PlatformAct act;
  std::optional<Eigen::Vector3d> p_HB;  // m, when the lift began
  cycle.run({{control::arm_grasp(platform, pick)}, ""}, nullptr, [&] {
    watch.step(cycle.cycle(), cycle.percepts());
    if (cycle.cycle().phase() != control::Phase::kLift) return;
    const ObjectReading object = world->object();
    if (!p_HB) p_HB = object.X_HB.translation();
    act.slide = (object.X_HB.translation() - *p_HB).norm();
    act.raised = object.height - start.height;
  });
  watch.step(cycle.cycle(), cycle.percepts());
  act.closed = watch.concluded() > 0;
  act.why = cycle.cycle().result().reason;
  if (act.closed) act.percepts = watch.percepts();
  return act;
}

}  // namespace prehend::eval
