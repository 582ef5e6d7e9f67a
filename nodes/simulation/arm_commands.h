#pragma once

#include <string>
#include <vector>

#include "msgs/joints.pb.h"
#include "nodes/arm_action/arm_action.h"
#include "prehend/graph/node.h"

namespace prehend::nodes {

/// A simulated arm that takes set points, too.
class CommandedArm : public MovedArm {
 public:
  /// Takes the arm over from whoever had it and moves it to `positions` [rad or m] of `joints`
  /// within its limits; braked when none has come for kWatchdog while it moves. Without joints it
  /// brakes. @return false where nothing was taken over: it is the same stream as before.
  /// @throws std::invalid_argument as simulation::check_set_point(); the arm goes on then.
  virtual bool command_arm(const std::vector<std::string>& joints,
                           const std::vector<double>& positions) = 0;
};

/// The topic /arm/command: set points of a controller that interpolates, one a cycle, as
/// msgs.JointCommand with the mode POSITION for all joints of the arm, or STOP.
class ArmCommands {
 public:
  ArmCommands(graph::Node& node, CommandedArm& arm, const EmergencyStopListener& emergency);

 private:
  void command(const msgs::JointCommand& command);

  graph::Node& node_;
  CommandedArm& arm_;
  const EmergencyStopListener& emergency_;
  std::string said_;  // of the last command that was refused, once
  graph::Subscription subscription_;
};

}  // namespace prehend::nodes
