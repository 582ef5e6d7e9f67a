#pragma once

#include <optional>

#include "prehend/belief/act_perceiver.h"
#include "prehend/control/arm_cycle.h"
#include "prehend/robot/grip.h"
#include "prehend/robot/kinematic_chain.h"
#include "prehend/robot/platform.h"

namespace prehend::control {

/// What a cycle's attempts perceive, as belief::predict_percepts() foretells it: how the hand
/// closes, and what it then lifts. An attempt that does not lift has no percepts lifted, one that
/// does not close none at all; nor has one whose percepts do not say where arm and hand are, or
/// that only feels the object (`gently`).
///
/// Not thread-safe.
class PerceptWatch {
 public:
  /// @param touch_force N, of a pad that touches; touch_counts as robot::touched_area().
  explicit PerceptWatch(const robot::Platform& platform,
                        double touch_force = robot::GripOptions().touch_force,
                        int touch_counts = robot::kTouchCounts);

  /// After each step of the cycle on these percepts.
  void step(const ArmCycle& cycle, const ArmPercepts& percepts);

  /// Of the last attempt that has concluded.
  const belief::Percepts& percepts() const { return perceived_; }
  int grasp_index() const { return grasp_index_; }  // of it, as Cycle::grasp_index() was
  int tries() const { return tries_; }              // of it, as CycleResult::tries() was
  /// How many attempts have closed, and lifted or not.
  int concluded() const { return concluded_; }

 private:
  std::optional<belief::ActMoment> moment(const ArmPercepts& percepts);
  void conclude();

  robot::Platform platform_;
  robot::KinematicChain chain_;
  double touch_force_;  // N
  int touch_counts_;
  std::optional<belief::ActPerceiver> act_;  // of the attempt that closes or lifts
  Phase phase_ = Phase::kWaiting;            // of the last step
  belief::ActMoment now_;                    // the last one that was known
  geometry::RigidTransform X_WH_ = geometry::RigidTransform::Identity();  // then
  int act_grasp_ = 0, act_tries_ = 0;                                     // of act_
  int seen_tries_ = 0, seen_touches_ = 0;                                 // of the cycle
  bool only_feels_ = false;                                               // the present attempt
  belief::Percepts perceived_;
  int grasp_index_ = 0, tries_ = 0, concluded_ = 0;
};

}  // namespace prehend::control
