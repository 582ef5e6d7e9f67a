#pragma once

#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/sensors.pb.h"
#include "nodes/grasp_cycle/arm_ports.h"
#include "nodes/grasp_cycle/cycle_robot.h"
#include "prehend/control/arm_cycle.h"
#include "prehend/graph/node.h"
#include "prehend/robot/grip.h"
#include "prehend/robot/hand_model.h"

namespace prehend::nodes {

/// Declares the parameters of ArmCycleOptions that arms alone have.
control::ArmCycleOptions declare_arm_options(graph::Node& node);

/// What the cycle of an arm needs to know besides the plan.
struct ArmRobotOptions {
  control::ArmCycleOptions cycle;
  int touch_counts = robot::kTouchCounts;  // above: a texel is touched
};

/// An arm with a hand: /arm/follow and /hand/move, /joint_states, /wrench and /tactile of its pads.
class ArmRobot : public CycleRobot {
 public:
  /// @param hand that the robot has.
  ArmRobot(graph::Node& node, const robot::HandModel& hand, const ArmRobotOptions& options);

  std::string lacks(const msgs::Grasp& grasp) const override;
  std::string prepare(const View& view, const Target& target) override;
  void start() override { cycle_.start(prepared_); }
  void take_prepared() override { cycle_.take_plan(prepared_); }
  void take_nothing(const std::string& problem) override { cycle_.take_plan({}, problem); }
  void step() override { cycle_.step(percepts()); }
  control::Cycle& cycle() override { return cycle_; }

 private:
  control::ArmPercepts percepts() const;

  graph::Node& node_;
  ArmActions arm_;
  HandActions hand_;
  control::ArmCycle cycle_;
  std::vector<graph::Subscription> subscriptions_;
  std::shared_ptr<const msgs::JointState> joints_;
  std::optional<Eigen::Vector3d> wrist_force_;  // N
  std::int64_t wrist_stamp_ = 0;                // ns
  int touch_counts_;
  std::map<std::string, std::shared_ptr<const msgs::TactileFrame>> pads_;  // that have spoken
  std::vector<control::ArmGrasp> prepared_;
};

}  // namespace prehend::nodes
