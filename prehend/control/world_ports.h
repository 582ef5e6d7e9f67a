#pragma once

#include <optional>
#include <string>
#include <vector>

#include "prehend/control/arm_cycle.h"
#include "prehend/simulation/robot_world.h"

// The arm and the hand of a simulated world as a cycle's ports, without messages between.
namespace prehend::control {

/// As the action /arm/follow of the node simulation: an arm that moves is braked first, and the
/// path begins where it then stands.
class WorldArm : public ArmPort {
 public:
  /// @pre the world outlives it and has an arm.
  explicit WorldArm(simulation::RobotWorld& world) : world_(world) {}
  void follow(const JointTrajectory& path, double contact_force) override;
  MotionStatus motion() override;
  std::string problem() override { return problem_; }
  void stop() override;

 private:
  struct Way {
    simulation::TrajectoryRequest request;
    double contact_force = 0;  // N
  };
  void begin(const Way& way);

  simulation::RobotWorld& world_;
  std::optional<Way> waiting_;  // until the arm stands
  std::string problem_;
};

/// As the action /hand/move of the node simulation.
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

/// What joints, wrist and pads show now. A pad's texels above `touch_counts` count as touched.
/// Each call asks the wrist's sensor anew, whose noise goes on.
ArmPercepts percepts_of(const simulation::RobotWorld& world, int touch_counts);

}  // namespace prehend::control
