#pragma once

#include <string>

#include "msgs/grasp.pb.h"
#include "nodes/grasp_cycle/view.h"
#include "prehend/control/cycle.h"

namespace prehend::nodes {

/// One kind of robot in the grasp cycle: its topics and actions, what of a plan it can execute, and
/// the control cycle that they feed.
class CycleRobot {
 public:
  virtual ~CycleRobot() = default;

  /// What it still has to hear before it can begin, in words; empty: nothing.
  virtual std::string waits_for() const { return {}; }
  /// What the grasp lacks to be executed, in words; empty: nothing.
  virtual std::string lacks(const msgs::Grasp& grasp) const = 0;

  /// Gets ready for the grasps of `target`, which has some. @return where the object is to be put,
  /// in words. @throws std::exception with the reason why they cannot be executed.
  virtual std::string prepare(const View& view, const Target& target) = 0;
  /// Starts a cycle on what was prepared. @throws as prepare().
  virtual void start() = 0;
  /// The running cycle goes on with what was prepared.
  virtual void take_prepared() = 0;
  /// A new look gave no grasp, for this reason.
  virtual void take_nothing(const std::string& problem) = 0;
  /// One step of the cycle on what the sensors say now.
  virtual void step() = 0;
  /// @pre start() was called
  virtual control::Cycle& cycle() = 0;
};

}  // namespace prehend::nodes
