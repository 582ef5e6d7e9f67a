#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "msgs/sensors.pb.h"
#include "nodes/grasp_cycle/cycle_robot.h"
#include "nodes/grasp_cycle/gripper_ports.h"
#include "nodes/gripper_source/gripper_source.h"
#include "prehend/control/grasp_cycle.h"
#include "prehend/graph/node.h"
#include "prehend/planning/free_places.h"
#include "prehend/robot/grip.h"

namespace prehend::nodes {

/// What the parallel gripper's cycle needs to know besides the plan.
struct GripperRobotOptions {
  control::CycleOptions cycle;
  planning::PlaceOptions place;
  int touch_counts = robot::kTouchCounts;  // above: a texel is touched
  double workspace = 0.55;                 // m, half the side of the square the carrier reaches
};

/// Declares the parameters that the parallel gripper alone has.
GripperRobotOptions declare_gripper_options(graph::Node& node);

/// A parallel gripper with two tactile pads on its carrier: /gripper/move, /gripper/command and
/// /carrier/move, /gripper/state, /tactile/left, /tactile/right, /wrench and /carrier/state.
class GripperRobot : public CycleRobot {
 public:
  /// @param gripper that the robot has; kept.
  GripperRobot(graph::Node& node, const GripperSource& gripper, const GripperRobotOptions& options);

  std::string waits_for() const override;
  std::string lacks(const msgs::Grasp& /*grasp*/) const override { return {}; }
  std::string prepare(const View& view, const Target& target) override;
  void start() override;
  void take_prepared() override { cycle_->take_plan(prepared_, move_W_); }
  void take_nothing(const std::string& problem) override {
    cycle_->take_plan({}, move_W_, problem);
  }
  void step() override { cycle_->step(percepts()); }
  control::Cycle& cycle() override { return *cycle_; }

 private:
  /// @throws geometry::InputError for a place that was given and cannot be used.
  Eigen::Vector3d choose_move(const View& view, const Target& target,
                              const Eigen::Vector3d& hand_W) const;
  control::Percepts percepts() const;

  graph::Node& node_;
  const GripperSource& gripper_;
  GripperRobotOptions options_;
  GripperActions gripper_port_;
  CarrierActions carrier_port_;
  std::vector<graph::Subscription> subscriptions_;
  std::shared_ptr<const msgs::TactileFrame> left_, right_;
  std::shared_ptr<const msgs::GripperState> gripper_state_;
  template <class Value>
  struct Stamped {
    Value value;
    std::int64_t stamp;  // ns
  };
  std::optional<Stamped<geometry::RigidTransform>> carrier_;  // X_WG
  std::optional<Stamped<double>> wrist_;                      // N
  std::vector<grasp::Grasp> prepared_;
  Eigen::Vector3d move_W_ = Eigen::Vector3d::Zero();  // of the object, when it is lifted
  std::optional<control::GraspCycle> cycle_;
};

}  // namespace prehend::nodes
