#pragma once

#include <cstddef>
#include <optional>

#include "prehend/belief/hand_evidence.h"
#include "prehend/belief/load_belief.h"
#include "prehend/control/arm_cycle.h"
#include "prehend/touch/hand_touch.h"

namespace prehend::control {

/// Watches what the holds of a cycle tell of the object's load: its weight, once the cycle has
/// weighed it; the share of the pads' force that friction gave then, and at which it slipped.
///
/// Shares are of holds of at least two pads that press against each other (their forces nearly add
/// up to nothing along the table), and of what hangs in them, less what their faces bear. Where the
/// wrist or the pads do not speak, nothing is said of that.
///
/// Not thread-safe.
class LoadWatch {
 public:
  /// @param touch_force N, that a pad feels at least when it touches.
  LoadWatch(robot::HandModel hand, double touch_force);

  /// After each step of the cycle on these percepts, with where the hand is by them.
  void step(const ArmCycle& cycle, const ArmPercepts& percepts, const belief::HandSample& hand);

  /// What the last hold told; complete when it has ended.
  const belief::LoadEvidence& found() const { return found_; }
  /// How many holds have ended that told something.
  int concluded() const { return concluded_; }

 private:
  std::optional<double> share_of(double load, const ArmPercepts& percepts,
                                 const belief::HandSample& hand) const;

  touch::HandTouch touch_;
  double touch_force_;  // N
  belief::LoadEvidence found_;
  bool open_ = false;  // a hold goes on
  std::size_t surprises_seen_ = 0;
  int concluded_ = 0;
};

}  // namespace prehend::control
