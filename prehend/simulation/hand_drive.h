#pragma once

#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/simulation/robot_bodies.h"

namespace prehend::simulation {

struct HandDriveOptions {
  /// How far a motor's position loop gives way under the joint's greatest effort [rad], > 0: sets
  /// the loop's stiffness, of the fingers too.
  double yield = 0.03;
  double sliding_yield = 5e-4;  // m, > 0, the same of a joint that slides
  double response = 0.03;       // s, > 0, of the loop when nothing is in the way
  /// Gears of hands lock themselves: a motor holds this many times what it drives with, >= 1.
  double holding = 3;
  double ramp = 0.1;          // s, > 0, from rest to the speed asked for
  double blocked_time = 0.1;  // s, > 0, without progress that counts as blocked
};

/// What one asks of a hand.
struct HandCommand {
  Eigen::VectorXd position;  // rad, of the motors; with until_contact: where to stop without it
  double speed = 0.3;        // share of the joints' greatest, in (0, 1]
  bool until_contact = false;
  Eigen::VectorXd effort;  // N m, of each motor once it presses; empty: what its joint can
};

/// The motors of a hand: each finger goes along a straight line of its joints' positions, slows
/// down as a motor's effort reaches what was asked for, and holds there (so its joints keep their
/// ratio, and a finger that meets the object first waits for the others). When an object gives way,
/// it goes on. Copy to save.
class HandDrive {
 public:
  HandDrive(const RobotBodies& robot, const HandDriveOptions& options = {});

  int size() const { return static_cast<int>(motors_.size()); }
  /// The motors' positions in `state` [rad].
  Eigen::VectorXd positions(const engines::MultibodyState& state) const;
  double position(const engines::MultibodyState& state, int motor) const;
  double velocity(const engines::MultibodyState& state, int motor) const;
  double effort(const engines::Multibody& system, int motor) const;  // N m, of the last step

  /// Holds where it is.
  void hold(const engines::MultibodyState& state);
  /// @throws std::invalid_argument in words naming the joint: another number of values, values that
  /// are not finite or beyond the limits, a speed outside (0, 1], an effort not in (0, its most].
  void move(const HandCommand& command);

  /// Sets drives and the stops of inner joints for the coming step.
  void before_step(double h, engines::Multibody& system, const engines::MultibodyState& state);

  Eigen::VectorXd targets() const;       // rad, where the motors were sent
  Eigen::VectorXd most_efforts() const;  // N m, of the motors' joints

  bool moving() const;   // some finger is still on its way
  bool blocked() const;  // some finger is stopped by what it presses on
  bool reached() const;  // all are where they were sent
  /// Fingers' shares of their way, of those that move.
  std::vector<double> progress() const;

 private:
  struct Motor {
    RobotBodies::Motor joint;
    engines::JointMechanics inner_mechanics;
    double start = 0, target = 0, reference = 0, reference_velocity = 0;
    double effort = 0;  // N m, to press with
    bool opens = false;
  };
  struct Group {
    std::vector<int> motors;
    double share = 1, duration = 0;  // of its way, s
    double pace = 0;                 // of the speed asked for
    double stuck = 0;                // s
  };
  HandDriveOptions options_;
  std::vector<Motor> motors_;
  std::vector<Group> groups_;
};

}  // namespace prehend::simulation
