#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "prehend/control/arm_cycle.h"
#include "prehend/grasp/planner.h"
#include "prehend/simulation/world.h"

namespace prehend::eval {

/// What the grasp cycle did to an object of a simulated world.
struct GraspExecution {
  control::CycleResult result;
  grasp::Grasp grasp;  // of the last attempt
  /// By which the object had moved from where it stood when that attempt began: what was at p_W is
  /// at X_moved * p_W.
  geometry::RigidTransform X_moved = geometry::RigidTransform::Identity();
  std::vector<control::Surprise> surprises;
  std::vector<std::pair<std::string, double>> phase_times;  // s, simulated
  double raised = 0;                                        // m, at most, over where it stood
  double moved = 0;         // m, along the table, from where it stood
  double final_height = 0;  // m, of its lowest point over the table, a while after the end
  /// m, by which the object moved in the hand from the start of the lift to the end of the
  /// carrying.
  double slip = 0;
  double seconds = 0;  // simulated
};

/// Grasps planned on a new look at the object, which has moved by X_moved (see GraspExecution) from
/// where it stood when the first plan was made.
using LookAgain = std::function<grasp::GraspPlan(const geometry::RigidTransform& X_moved)>;

/// Executes ranked grasps of the object `object` (index of the world's bodies) by ArmCycle on the
/// stage at 100 Hz, as the node grasp_cycle does, with the world's ideal readings. The stage moves
/// on straight lines: up, across, down to the pregrasp, and 0.15 m sideways with the object. After
/// a failed attempt the cycle looks again, if there is `look_again`: the new plan is there at once.
/// Ends after `time_limit` [s, simulated] at the latest.
GraspExecution execute_grasps(simulation::World& world, std::size_t object,
                              const grasp::GraspPlan& plan, double time_limit = 120,
                              const LookAgain& look_again = nullptr);

}  // namespace prehend::eval
