#pragma once

#include <memory>
#include <optional>

#include <Eigen/Core>

#include "prehend/motion/robot_in_world.h"
#include "prehend/robot/platform.h"

namespace prehend::control {

/// What stands round a robot that is moved by hand.
struct JogSurroundings {
  /// m, height in the world of a level table, "table"; none: there is none. Where the arm's base
  /// stands on it (within 0.3 m of its height), it has a hole of 0.4 m round the base.
  std::optional<double> table = 0.0;
  double clearance = 0.005;  // m, >= 0, kept from it
  double resolution = 0.03;  // m, > 0, of the balls that hold the robot's shapes
};

/// The platform's arm with its hand's joints at `hand` (all of the hand's, see
/// HandModel::all_positions()), among what stands round it. What it holds, and objects on the
/// table, are not known.
/// @throws std::invalid_argument for lengths that are none, as with_hand_at().
std::shared_ptr<const motion::RobotInWorld> jog_space(const robot::Platform& platform,
                                                      const Eigen::VectorXd& hand,
                                                      const JogSurroundings& around = {});

}  // namespace prehend::control
