#pragma once

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "prehend/contact/grasp_stepper.h"
#include "prehend/contact/parallel_grasp.h"

namespace prehend::simulation {

/// The soft-contact paper's work cycle: a gripper comes down on a box on a table, closes under
/// velocity control until both pads feel it, presses under force control, lifts, holds, puts down,
/// opens and goes. Both jaws have one drive. Phases end at fixed times, so that runs compare.
enum class CyclePhase {
  kApproach,
  kClose,
  kPress,
  kLift,
  kHold,
  kLower,
  kRest,
  kRelease,
  kRetreat
};
constexpr int kCyclePhases = 9;
const char* to_string(CyclePhase phase);

struct WorkCycleOptions {
  /// Box, mass, pad and law. `coupled` and `on_ground` are set by the cycle.
  contact::ParallelGraspOptions grasp;
  std::optional<contact::Shape> shape;  // felt instead of the box, within its bounds
  double coverage = 1;                  // share of the pad's length on the box, above 0 to 1
  double close_speed = 0.01;            // m/s of the opening
  double touch_force = 0.5;             // N on each pad that ends velocity control
  double grip_force = 0;                // N of each jaw; 0: twice what the weight needs
  double lift_height = 0.1;             // m
  double speed = 0.05;                  // m/s of the gripper
  double acceleration = 0.2;            // m/s^2
  double stiction = 0;                  // N, static friction of the drive; 3/4 of it when it moves
  contact::StepOptions step;
  contact::SolveOptions solve;
  double sample_period = 0;  // s, of samples; 0: only the phases' ends
};

struct CycleSample {
  double time = 0;  // s
  CyclePhase phase = CyclePhase::kApproach;
  double left = 0, right = 0;                     // N, sums of the pads
  double opening = 0;                             // m
  double speed = 0;                               // m/s of the opening, negative closes
  Eigen::Vector3d box = Eigen::Vector3d::Zero();  // m, its centre
};

/// A phase's end.
struct PhaseEnd {
  CycleSample sample;
  std::vector<double> left_image, right_image;  // N of each texel, row by row
};

struct WorkCycleResult {
  std::vector<CycleSample> samples;
  std::array<PhaseEnd, kCyclePhases> ends;
  double touch_time = 0;  // s, when velocity control ended; the phase's end when it never did
  double grip_force = 0;  // N
  double duration = 0;    // s, simulated
  double cpu_time = 0;    // s, of this thread
  std::int64_t steps = 0, rejected = 0;
};

/// @throws std::invalid_argument for values out of range (naming the field).
WorkCycleResult run_work_cycle(const WorkCycleOptions& options);

/// Largest distance between the box's centres of two runs [m], at the phases' ends and at samples
/// of one time.
double largest_difference(const WorkCycleResult& a, const WorkCycleResult& b);

}  // namespace prehend::simulation
