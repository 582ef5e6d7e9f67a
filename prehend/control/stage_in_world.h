#pragma once

#include <memory>
#include <string>
#include <vector>

#include "prehend/control/cycle_world.h"
#include "prehend/control/pad_gripper.h"
#include "prehend/control/world_arm.h"
#include "prehend/simulation/stage_arm.h"
#include "prehend/simulation/world.h"

namespace prehend::control {

/// The drive of a simulated world's gripper as a port, as the action /gripper/move and the topic
/// /gripper/command of the node simulation, but for its watchdog: nothing falls silent here.
class WorldGripper : public GripperPort {
 public:
  /// @pre the world outlives it.
  explicit WorldGripper(simulation::World& world) : world_(world) {}
  void move_to(double opening, double speed) override;
  MotionStatus motion() override;
  void command_velocity(double speed, double current_limit) override;
  void stop() override;

 private:
  simulation::World& world_;
  double target_ = 0;     // m
  bool refused_ = false;  // the last move_to
};

/// A stage with a gripper that regulates its grip (PadGripper), in their world.
class StageInWorld : public CycleWorld, private DrivenArm {
 public:
  /// Keeps the reference. @pre the world's carrier is carrier_of(platform, home), its gripper the
  /// platform's, with pads that have texels
  /// @param gripper touch_force and stale_time as the cycle's.
  /// @throws as carrier_of(); std::invalid_argument for options out of range.
  StageInWorld(simulation::World& world, const robot::Platform& platform, const std::string& home,
               const PadGripperOptions& gripper = {});

  void advance(int steps) override;
  double step_time() const override { return world_.scene().step; }
  double time() const override { return world_.time(); }
  ArmPort& arm() override { return arm_; }
  HandPort& hand() override { return hand_; }
  ArmPercepts percepts(int touch_counts) override;

 private:
  void follow(const simulation::TrajectoryRequest& request, double contact_force) override;
  void stop() override { stage_.stop(); }
  const simulation::ArmDrive& drive() const override { return stage_.drive(); }
  bool at_rest() const override { return !world_.carrier().moving; }
  bool stopped_by_contact() const override { return stage_.stopped_by_contact(); }

  simulation::World& world_;
  simulation::StageArm stage_;
  WorldArm arm_;
  WorldGripper drive_;
  PadGripper hand_;
  std::shared_ptr<const touch::FeltPad> left_, right_;
};

}  // namespace prehend::control
