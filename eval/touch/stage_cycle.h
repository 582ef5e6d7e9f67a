#pragma once

#include <map>
#include <string>
#include <vector>

#include "prehend/control/cycle.h"
#include "prehend/control/joint_trajectory.h"

// The soft-contact paper's work cycle (its figures 4 to 7) through the parts that ship: the task
// work_cycle, the cycle, the gripper that regulates its grip by its pads, the PG70's drive, the
// pads' electronics, and the world.
namespace prehend::eval::touch {

inline constexpr double kHiddenStiction = 15;  // N, that a stuck drive's controller does not know

/// Of the stage's x, y, z [m] and yaw [rad], along a quintic in time, at rest at both ends.
control::JointTrajectory stage_way(const std::vector<double>& from, const std::vector<double>& to);

struct StageCycleOptions {
  double coverage = 1;          // share of the pads' length that is on the box, in (0, 1]
  double grip_force = 12;       // N, > 0, that the pads are to feel, their mean
  double stiffness = 0;         // N/m, of a texel; 0: the pads' own
  bool realistic_pads = false;  // TactileSensorOptions and FoamMemory::realistic()
  /// The drive sticks by kHiddenStiction more than its controller believes, and its thread's
  /// friction grows with the load; otherwise it has no friction.
  bool stuck_drive = false;
};

struct StageCycleSample {
  double time = 0;  // s
  control::Phase phase = control::Phase::kWaiting;
  double left = 0, right = 0;  // N, sums as the pads' electronics show them
  double opening = 0;          // m
  double height = 0;           // m, of the box's lowest point
  double mean() const { return (left + right) / 2; }
};

struct PadImages {
  std::vector<double> left, right;  // counts, row by row
};

struct StageCycle {
  std::vector<StageCycleSample> samples;       // every 10 ms
  std::map<control::Phase, PadImages> images;  // at the ends of the phases that touch
  control::CycleResult result;
  double touch_time = 0;  // s, when both pads had touched: force control begins
  double lift_time = 0;   // s, when the lift began
  double settled_after =
      0;            // s, of force control, from when on the sum is within 2 % until the lift
  double rise = 0;  // N/s, greatest of the mean until then
  double jump = 0;  // N, that the mean rises in the first 20 ms of force control
  double held_left = 0, held_right = 0;  // N, when the lift begins
  double raised = 0;                     // m, of the box at most
};

/// @throws std::invalid_argument for options out of range, geometry::InputError for files that are
/// not there. Same options: bitwise the same run.
StageCycle run_stage_cycle(const StageCycleOptions& options);

}  // namespace prehend::eval::touch
