#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "prehend/control/cycle_world.h"
#include "prehend/control/world_arm.h"
#include "prehend/simulation/robot_world.h"

namespace prehend::control {

/// The hand of a simulated world as a cycle's port, as the action /hand/move of the node
/// simulation.
class WorldHand : public HandPort {
 public:
  /// @pre the world outlives it.
  explicit WorldHand(simulation::RobotWorld& world) : world_(world) {}
  void move(const std::vector<std::string>& joints, const std::vector<double>& positions,
            double speed, bool until_contact, const std::vector<double>& effort) override;
  MotionStatus motion() override;
  std::string problem() override { return problem_; }
  std::vector<double> positions() override;  // of the joints named last
  void stop() override;

 private:
  simulation::RobotWorld& world_;
  std::vector<int> motors_;
  bool refused_ = false;
  std::string problem_;
};

/// An arm with a hand that its joints move, in their world. Each percepts() asks the wrist's sensor
/// anew, whose noise goes on.
class ArmInWorld : public CycleWorld, private DrivenArm {
 public:
  /// Keeps the reference. @pre the world has an arm
  explicit ArmInWorld(simulation::RobotWorld& world);

  void advance(int steps) override {
    for (int i = 0; i < steps; ++i) world_.step();
  }
  double step_time() const override { return world_.options().step; }
  double time() const override { return world_.time(); }
  ArmPort& arm() override { return arm_; }
  HandPort& hand() override { return hand_; }
  ArmPercepts percepts(int touch_counts) override;

 private:
  void follow(const simulation::TrajectoryRequest& request, double contact_force) override;
  void stop() override { world_.arm().stop(); }
  const simulation::ArmDrive& drive() const override { return world_.arm(); }
  bool at_rest() const override { return world_.arm().at_rest(); }
  bool stopped_by_contact() const override { return world_.stopped_by_contact(); }

  simulation::RobotWorld& world_;
  WorldArm arm_;
  WorldHand hand_;
  std::map<std::string, std::shared_ptr<const touch::FeltPad>> felt_;  // pads, by name
};

}  // namespace prehend::control
