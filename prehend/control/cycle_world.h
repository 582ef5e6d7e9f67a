#pragma once

#include "prehend/control/arm_cycle.h"

namespace prehend::control {

/// What CycleInWorld needs of a simulated world and the platform's robot in it: ArmInWorld where
/// joints move the hand, StageInWorld where a gripper's drive does.
class CycleWorld {
 public:
  virtual ~CycleWorld() = default;
  virtual void advance(int steps) = 0;   // each of step_time()
  virtual double step_time() const = 0;  // s
  virtual double time() const = 0;       // s, simulated
  virtual ArmPort& arm() = 0;
  virtual HandPort& hand() = 0;
  /// What all sensors show now. A pad's texels above `touch_counts` count as touched.
  virtual ArmPercepts percepts(int touch_counts) = 0;
};

}  // namespace prehend::control
