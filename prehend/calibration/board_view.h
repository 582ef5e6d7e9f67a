#pragma once

#include <optional>
#include <string>
#include <vector>

#include <Eigen/Core>

#include "prehend/calibration/calibration_board.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/perception/camera_calibration.h"

namespace prehend::calibration {

/// A board's corners in one image.
struct BoardView {
  std::string name;                     // of the image
  std::vector<int> ids;                 // of the board's corners, ascending
  std::vector<Eigen::Vector2d> pixels;  // as many; (0, 0) is the centre of the upper left pixel
};

/// Finds the board's corners to a few hundredths of a pixel. A chessboard is found as a whole or
/// not at all (OpenCV's findChessboardCorners), of other boards any part (markers: S.
/// Garrido-Jurado et al., Pattern Recognition 47(6), 2014; tags' codes: E. Olson, ICRA 2011). Then
/// each corner is moved to where the grey levels' gradients round it are across the way to it (W.
/// Foerstner, E. Guelch, 1987; OpenCV's cornerSubPix).
/// @return without corners when the board is not in the image. @throws std::invalid_argument for
/// an empty image.
BoardView find_board(const geometry::ColorImage& image, const CalibrationBoard& board,
                     const std::string& name = "");

/// Pose X_CT of the board in the optical frame by the view's corners: IPPE (T. Collins, A. Bartoli,
/// IJCV 109(3), 2014), then least squares of the reprojection. None for fewer than four corners or
/// corners in a line.
struct BoardPose {
  geometry::RigidTransform X_CT = geometry::RigidTransform::Identity();
  double rms = 0;  // pixels, of the corners
};
std::optional<BoardPose> board_pose(const BoardView& view, const CalibrationBoard& board,
                                    const perception::CameraCalibration& camera);

/// Pixel of a point in front of a camera with distortion.
Eigen::Vector2d project(const perception::CameraCalibration& camera, const Eigen::Vector3d& p_C);

}  // namespace prehend::calibration
