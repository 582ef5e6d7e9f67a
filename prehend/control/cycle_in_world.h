#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "prehend/control/arm_cycle.h"
#include "prehend/control/cycle_world.h"
#include "prehend/robot/grip.h"

namespace prehend::control {

struct CycleInWorldOptions {
  double period = 0.01;  // s, > 0, of the cycle, and of the joints and the wrist; the pads' frames
                         // come every second time
  int touch_counts = robot::kTouchCounts;  // >= 0, above: a texel is touched
  double time_limit = 240;                 // s, > 0, simulated, of run()
};

/// Grasps to execute, best first, or why there are none.
struct GraspsToTry {
  std::vector<ArmGrasp> grasps;
  std::string problem;
  Advice advice = {};
};

/// The cycle of a platform in a simulated world, in one thread and without messages: what the nodes
/// simulation and grasp_cycle do together, but that nothing takes time between them and a new look
/// gives its plan at once. Same world and same grasps: bitwise the same run.
class CycleInWorld {
 public:
  /// @pre the world outlives it. @throws std::invalid_argument for options out of range.
  CycleInWorld(CycleWorld& world, const ArmCycleOptions& options,
               const CycleInWorldOptions& run = {});

  /// As ArmCycle::judge_grips().
  void judge_grips(GripJudge judge) { cycle_.judge_grips(std::move(judge)); }

  /// The world goes on by a period, the cycle makes a step.
  void step();

  /// Executes `first` to the end of the cycle, or to the time limit, at which it is aborted.
  /// @param look_again grasps planned on a new look after a failed attempt; of use with
  /// ArmCycleOptions::look_timeout. @param after_step called after each step().
  const CycleResult& run(GraspsToTry first,
                         const std::function<GraspsToTry()>& look_again = nullptr,
                         const std::function<void()>& after_step = nullptr);

  const ArmCycle& cycle() const { return cycle_; }
  const ArmPercepts& percepts() const { return percepts_; }  // of the last step

 private:
  void feel();

  CycleWorld& world_;
  CycleInWorldOptions options_;
  ArmCycle cycle_;
  ArmPercepts percepts_;
  int steps_;                     // of the world in a period
  long count_ = 0;                // periods
  std::vector<PadPercept> pads_;  // as in the last frames
  std::vector<touch::PadFrame> frames_;
  double frame_time_ = 0;  // s
};

}  // namespace prehend::control
