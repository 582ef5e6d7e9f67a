#pragma once

#include <memory>
#include <optional>

#include "prehend/calibration/hand_eye.h"
#include "prehend/motion/robot_in_world.h"
#include "prehend/robot/platform.h"

namespace prehend::calibration {

/// What an arm that is driven to hand-eye poses must not touch, beside itself.
struct CalibrationSurroundings {
  CameraMount mount = CameraMount::kHand;
  HandEyeUnknowns guess;        // where camera and board are about
  std::optional<double> table;  // m, height over the base of a level table
  double camera_radius = 0.06;  // m, of a ball round the optical centre, 0: no camera
  /// m, that is kept from who stands: more than the guess is off. What the flange carries keeps
  /// nothing from the arm's own links beyond its radius.
  double clearance = 0.03;
};

/// The platform's arm with its hand's joints at `hand` (all of the hand's, see
/// HandModel::all_positions()) among the table, the board and the camera: who is carried by the
/// flange is held there, who stands is an obstacle ("table", "board", "camera"). What is held is
/// not tested against the last two joints' links: it is mounted there.
/// @throws std::invalid_argument for lengths that are negative or not finite, as with_hand_at().
std::unique_ptr<motion::RobotInWorld> calibration_space(const robot::Platform& platform,
                                                        const Eigen::VectorXd& hand,
                                                        const CalibrationBoard& board,
                                                        const CalibrationSurroundings& around);

}  // namespace prehend::calibration
