#pragma once

#include <random>
#include <vector>

#include "prehend/calibration/calibration_board.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/perception/camera_calibration.h"

namespace prehend::testing {

/// What a camera does to an ideal image.
struct ImageFlaws {
  double blur = 1.0;   // pixels, standard deviation
  double noise = 2.0;  // of 255 grey levels, standard deviation
};

/// Images of a board as a camera with distortion sees it: a pixel is the mean of 5 x 5 rays that
/// are followed back through the lens onto the board, under a slope of light, then blurred, noisy
/// and rounded. White 50 mm round the board, grey beyond.
class BoardRenderer {
 public:
  BoardRenderer(const calibration::CalibrationBoard& board,
                const perception::CameraCalibration& camera, const ImageFlaws& flaws = {});

  geometry::ColorImage image(const geometry::RigidTransform& X_CT, std::mt19937& random) const;

 private:
  calibration::CalibrationBoard board_;
  perception::CameraCalibration camera_;
  ImageFlaws flaws_;
  calibration::DrawnBoard drawn_;
  std::vector<Eigen::Vector2f> rays_;  // of pixels' upper left corners, x and y at z = 1
};

/// Poses X_CT of a board that looks at the camera: tilted up to 40 degrees to all sides, turned,
/// everywhere in the image, some near and some far. All corners are in view.
std::vector<geometry::RigidTransform> board_poses(const calibration::CalibrationBoard& board,
                                                  const perception::CameraCalibration& camera,
                                                  int count, std::mt19937& random);

/// 1280 x 960 pixels with a lens that is bent by some pixels.
perception::CameraCalibration bent_camera();

/// The same at half the size.
perception::CameraCalibration small_camera();

calibration::CalibrationBoard charuco_board();
calibration::CalibrationBoard chessboard();
calibration::CalibrationBoard apriltag_grid();

/// Angle of the rotation between two poses [rad].
double angle_between(const geometry::RigidTransform& a, const geometry::RigidTransform& b);

}  // namespace prehend::testing
