#include "prehend/calibration/calibration_space.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <utility>
#include <vector>

#include "prehend/motion/robot_spheres.h"

namespace prehend::calibration {
namespace {

constexpr double kThickness = 0.02;  // m, of a board that is glued to something, behind its print
constexpr double kBorder = 0.02;     // m, of it round the print

void check(const CalibrationSurroundings& around) {
  if (!(around.camera_radius >= 0 && around.camera_radius < 10)) {
    throw std::invalid_argument("the camera's radius must be a length of 0 or more [m]");
  }
  if (!(around.clearance >= 0 && around.clearance < 10)) {
    throw std::invalid_argument("the clearance must be a length of 0 or more [m]");
  }
  if (around.table && !std::isfinite(*around.table)) {
    throw std::invalid_argument("the table's height is not finite");
  }
}

Eigen::Vector3d board_sides(const CalibrationBoard& board) {
  return {board.size().x() + 2 * kBorder, board.size().y() + 2 * kBorder, kThickness};
}

// T is at the corner of the print, z goes into the board.
geometry::RigidTransform board_middle(const CalibrationBoard& board) {
  geometry::RigidTransform X_TM = geometry::RigidTransform::Identity();
  X_TM.translation() =
      Eigen::Vector3d(0.5 * board.size().x(), 0.5 * board.size().y(), 0.5 * kThickness);
  return X_TM;
}

// Balls whose union holds the board: one for each square of a raster, round it.
std::vector<motion::RobotSphere> board_balls(const CalibrationBoard& board,
                                             const geometry::RigidTransform& X_FT) {
  const Eigen::Vector3d sides = board_sides(board);
  const geometry::RigidTransform X_FM = X_FT * board_middle(board);
  const auto count = [](double side) {
    return std::max(1, static_cast<int>(std::ceil(side / 0.05)));
  };
  const int columns = count(sides.x()), rows = count(sides.y());
  const Eigen::Vector3d cell(sides.x() / columns, sides.y() / rows, sides.z());
  std::vector<motion::RobotSphere> balls;
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < columns; ++c) {
      const Eigen::Vector3d p_M(cell.x() * (c + 0.5) - 0.5 * sides.x(),
                                cell.y() * (r + 0.5) - 0.5 * sides.y(), 0);
      motion::RobotSphere ball;
      ball.p_J = X_FM * p_M;
      ball.radius = 0.5 * cell.norm();
      balls.push_back(ball);
    }
  }
  return balls;
}

}  // namespace

std::unique_ptr<motion::RobotInWorld> calibration_space(const robot::Platform& platform,
                                                        const Eigen::VectorXd& hand,
                                                        const CalibrationBoard& board,
                                                        const CalibrationSurroundings& around) {
  check(around);
  motion::CollisionWorld world;
  if (around.table) world.add_plane("table", {Eigen::Vector3d::UnitZ(), *around.table});
  std::vector<motion::RobotSphere> held;
  if (around.mount == CameraMount::kHand) {
    world.add_box("board", around.guess.X_QT * board_middle(board), board_sides(board));
    if (around.camera_radius > 0) {
      motion::RobotSphere camera;
      camera.p_J = around.guess.X_PC.translation();
      camera.radius = around.camera_radius;
      held.push_back(camera);
    }
  } else {
    held = board_balls(board, around.guess.X_QT);
    if (around.camera_radius > 0) {
      world.add_sphere("camera", around.guess.X_PC.translation(), around.camera_radius);
    }
  }
  auto space = std::make_unique<motion::RobotInWorld>(
      platform.arm_chain(),
      motion::make_robot_spheres(platform.with_hand_at(hand), platform.base, platform.flange),
      std::move(world), around.clearance);
  if (!held.empty()) space->attach(held);
  return space;
}

}  // namespace prehend::calibration
