#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/simulation/actuator.h"
#include "prehend/simulation/joint_reference.h"
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

/// What one asks of motors from now on, until told otherwise.
struct MotorsCommand {
  robot::JointMode mode = robot::JointMode::kStop;
  std::vector<int> motors;     // each once
  std::vector<double> values;  // as many, by mode; none of kStop
};

/// The motors of a hand. move(): each finger goes along a straight line of its joints' positions,
/// slows down as a motor's effort reaches what was asked for, and holds there (so its joints keep
/// their ratio, and a finger that meets the object first waits for the others). When an object
/// gives way, it goes on. command(): each motor by itself, see JointReference. Motors that the
/// hand's file describes move by their actuators, the others by ideal position loops. Copy to save.
class HandDrive {
 public:
  /// @throws geometry::InputError for a motor that cannot be (ActuatorRegistry::make).
  HandDrive(const RobotBodies& robot, const HandDriveOptions& options = {});
  /// What the motors' actuators do to their joints, for those of the engine.
  void put_mechanics(std::vector<engines::JointMechanics>& mechanics) const;

  int size() const { return static_cast<int>(motors_.size()); }
  /// The motors' positions in `state` [rad].
  Eigen::VectorXd positions(const engines::MultibodyState& state) const;
  double position(const engines::MultibodyState& state, int motor) const;
  double velocity(const engines::MultibodyState& state, int motor) const;
  double effort(const engines::Multibody& system, int motor) const;  // N m, of the last step

  /// A, of a motor whose actuator knows; else not a number.
  double current(int motor) const;

  /// Begins anew where it is, at rest.
  void begin(const engines::MultibodyState& state);
  /// Holds where it is.
  void hold(const engines::MultibodyState& state);
  /// @throws std::invalid_argument in words naming the joint: another number of values, values that
  /// are not finite or beyond the limits, a speed outside (0, 1], an effort not in (0, its most].
  void move(const HandCommand& command);
  /// Ends what move() began; motors that are not named hold or do what they were told before.
  /// Speeds, efforts and voltages are cut to what the joint and its motor can.
  /// @throws std::invalid_argument in words naming the joint, and nothing changes: another number
  /// of values, values that are not finite, a position beyond the limits, a voltage for a motor
  /// that the hand's file does not describe.
  void command(const MotorsCommand& command);
  /// Stops the motors that move by command(). True when there were any.
  bool stop_commanded(const engines::MultibodyState& state);

  /// Sets drives and the stops of inner joints for the coming step.
  /// @throws std::runtime_error naming an actuator that gives no finite effort.
  void before_step(double h, engines::Multibody& system, const engines::MultibodyState& state);
  /// What the step did to the actuators.
  void after_step(double h, const engines::Multibody& system, const engines::MultibodyState& state);

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
    std::optional<JointReference> commanded;  // by command()
    ActuatedJoint actuated;
    std::shared_ptr<const Actuator> actuator;  // none: an ideal position loop
    std::vector<double> actuator_state;
    double inertia = 0;  // kg m^2, of motor and link; what hangs on it has more
  };
  void check(const MotorsCommand& command) const;
  void advance_groups(double h, const engines::Multibody& system);
  static contact::SlideCommand driven(Motor& motor, const ActuatorRequest& request, double h,
                                      const JointMotion& start);
  contact::SlideCommand commanded_drive(Motor& motor, double h, const JointMotion& start,
                                        double effort) const;
  JointMotion motion(const engines::MultibodyState& state, int motor) const {
    return {position(state, motor), velocity(state, motor)};
  }
  double acceleration(const Motor& motor) const {  // rad/s^2
    return motor.joint.max_velocity / options_.ramp;
  }
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
