#pragma once

#include <string>

#include "msgs/sensors.pb.h"
#include "nodes/gripper_source/gripper_source.h"
#include "prehend/graph/node.h"
#include "prehend/robot/platform.h"
#include "prehend/touch/felt_pad.h"

namespace prehend::nodes {

/// The pads of the platform's hand, for nodes that read their frames (/tactile/PAD).
class HandPads {
 public:
  /// Declares the parameters `platform`, `platforms`, `gripper` and `threshold`, and listens to
  /// what a gripper says of itself. @throws geometry::InputError for a platform that cannot be
  /// read.
  explicit HandPads(graph::Node& node);

  const robot::Platform& platform() const { return platform_; }
  /// The hand is a gripper that is moved, and says how far it is open, through /gripper.
  bool is_gripper() const { return platform_.hand_port == robot::HandPort::kGripper; }
  /// Who says now which pads they are: its name, empty for the platform's file.
  std::string said_by() const;

  /// The pad that sent `frame`. @throws as convert::felt_pad().
  touch::FeltPad felt(const robot::HandPad& pad, const msgs::TactileFrame& frame) const;

 private:
  robot::Platform platform_;
  int threshold_ = 0;  // counts
  GripperSource gripper_;
};

}  // namespace prehend::nodes
