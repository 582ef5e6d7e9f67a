#pragma once

#include <optional>
#include <string>

#include "prehend/control/arm_cycle.h"
#include "prehend/simulation/arm_drive.h"

namespace prehend::control {

/// What moves the joints of a simulated arm.
class DrivenArm {
 public:
  virtual ~DrivenArm() = default;
  /// Starts; stops where the wrist feels more than `contact_force` [N] if that is positive.
  /// @throws std::invalid_argument as simulation::check_trajectory(); the last one is forgotten
  /// then. @pre at_rest()
  virtual void follow(const simulation::TrajectoryRequest& request, double contact_force) = 0;
  virtual void stop() = 0;
  virtual const simulation::ArmDrive& drive() const = 0;
  virtual bool at_rest() const = 0;
  virtual bool stopped_by_contact() const = 0;
};

/// A simulated arm as a cycle's port, without messages between. As the action /arm/follow of the
/// node simulation: an arm that moves is braked first, and the path begins, at a call of motion(),
/// where it then stands.
class WorldArm : public ArmPort {
 public:
  /// Keeps the reference.
  explicit WorldArm(DrivenArm& arm) : arm_(arm) {}
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

  DrivenArm& arm_;
  std::optional<Way> waiting_;  // until the arm stands
  std::string problem_;
};

}  // namespace prehend::control
