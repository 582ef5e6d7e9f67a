#pragma once

#include <cstdint>
#include <string>

#include "msgs/belief.pb.h"
#include "nodes/motion_goal/motion_goal.h"
#include "prehend/control/arm_ports.h"
#include "prehend/graph/node.h"
#include "prehend/robot/kinematic_chain.h"
#include "prehend/robot/platform.h"

namespace prehend::nodes {

/// The action /held/look: who keeps the model of what is held looks at it.
class HeldLooks : public control::InspectionPort {
 public:
  /// `platform` lives longer.
  HeldLooks(graph::Node& node, const robot::Platform& platform);

  /// What is held from now on is this object, of the view with this stamp [ns].
  void hold(std::int64_t stamp, std::uint32_t object_id);

  void look(const control::ArmPercepts& gripped, const control::ArmPercepts& now) override;
  control::MotionStatus status() override;
  std::string found() override { return found_; }
  void stop() override { goal_.stop(); }

 private:
  graph::Node& node_;
  const robot::Platform& platform_;
  robot::KinematicChain chain_;
  MotionGoal<msgs::HeldLookGoal, msgs::HeldLookFeedback, msgs::HeldLookResult> goal_;
  std::int64_t stamp_ = 0;
  std::uint32_t object_id_ = 0;
  bool asked_ = false;
  std::string found_;
};

}  // namespace prehend::nodes
