#pragma once

#include <deque>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "prehend/belief/attempt.h"
#include "prehend/control/arm_cycle.h"
#include "prehend/control/load_watch.h"
#include "prehend/robot/kinematic_chain.h"
#include "prehend/robot/platform.h"

namespace prehend::control {

/// Watches what the attempts of a cycle find out about the object.
///
/// What the hand went through on the approach and while it closed, until something was touched
/// first, is empty: pads tell, and the wrist by more than `contact_force`. Of fingers that were
/// stopped without a pad that touches only the approach counts, as they have pushed with what does
/// not feel. The first touch of each pad is of the object where it was seen; when the hand has
/// closed it has moved, by no more than the pads went on, and is felt by all pads that touch. What
/// a probe's fingertip has met without a pad that says more is at its foremost point.
///
/// A pad that feels something before the approach begins is not believed in that attempt.
///
/// Not thread-safe.
class AttemptWatch {
 public:
  /// @throws as belief::HandEvidence.
  AttemptWatch(const robot::Platform& platform, double contact_force,
               double touch_force = robot::GripOptions().touch_force);

  /// After each step of the cycle on these percepts. Percepts that do not say where arm and hand
  /// are are passed over.
  void step(const ArmCycle& cycle, const ArmPercepts& percepts);

  /// What the present attempt has found out until now; complete once it lifts or has failed.
  const belief::Attempt& attempt() const { return attempt_; }
  /// How many attempts have come to that.
  int concluded() const { return concluded_; }
  /// What its holds tell of the object's load.
  const LoadWatch& load() const { return load_; }

 private:
  struct Moment {
    double time = 0;  // s
    belief::HandSample hand;
  };
  void begin(const ArmCycle& cycle);
  double force_of(const std::string& pad) const;  // N
  bool pads_touch() const;
  /// Of the pads that are believed and touch: each as the hand was when it spoke.
  std::vector<belief::Contact> contacts() const;
  /// Until the pads spoke last.
  void extend_way();
  void conclude(const ArmCycle& cycle);
  double farthest(const belief::HandSample& from, const belief::HandSample& to) const;

  robot::Platform platform_;
  robot::KinematicChain chain_;
  belief::HandEvidence evidence_;
  LoadWatch load_;
  double contact_force_, touch_force_;  // N
  int attempts_ = 0, concluded_ = 0;
  bool open_ = false;                 // the attempt goes on
  std::size_t surprises_before_ = 0;  // it
  std::set<std::string> not_believed_;
  std::vector<belief::HandSample> way_;
  std::size_t approached_ = 0;  // samples of the way before it closes
  std::deque<Moment> moments_;  // the newest
  ArmPercepts percepts_;
  std::optional<belief::HandSample> first_touch_;  // of anything, in this attempt
  belief::Attempt attempt_;
};

}  // namespace prehend::control
