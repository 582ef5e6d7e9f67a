#pragma once

#include <string>
#include <utility>
#include <vector>

#include "prehend/control/grasp_cycle.h"
#include "prehend/grasp/planner.h"
#include "prehend/simulation/world.h"

namespace prehend::eval {

/// What the grasp cycle did to an object of a simulated world.
struct GraspExecution {
  control::CycleResult result;
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

/// Executes ranked grasps of the object `object` (index of the world's bodies) by GraspCycle at 100
/// Hz, as the node grasp_cycle does, with the world's ideal readings. Ends after `time_limit` [s,
/// simulated] at the latest.
GraspExecution execute_grasps(simulation::World& world, std::size_t object,
                              const grasp::GraspPlanResult& plan,
                              const control::CycleOptions& options = {}, double time_limit = 120);

}  // namespace prehend::eval
