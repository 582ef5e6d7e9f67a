#pragma once

#include <string>
#include <vector>

#include "prehend/calibration/board_view.h"

namespace prehend::calibration {

struct CameraOptions {
  std::string name = "camera";
  /// Coefficients of the lens: 5 (k1 k2 p1 p2 k3, `plumb_bob`) or 8 (`rational_polynomial`).
  int coefficients = 5;
  /// A view is left out when its corners are off by more than so many times the middle view's.
  double worst_view = 4;
};

/// How well one view fits.
struct ViewFit {
  std::string name;
  bool used = false;
  std::string why_not;  // empty where it is used
  int corners = 0;
  double rms = 0;  // pixels; of the distance of a found corner to where it should be
  geometry::RigidTransform X_CT = geometry::RigidTransform::Identity();
};

/// A corner as found and as the fitted camera sees it.
struct CornerFit {
  int view = 0;
  Eigen::Vector2d pixel, residual;  // pixels; residual = found - predicted
};

struct CameraFit {
  perception::CameraCalibration calibration;  // R is the unit matrix, P = [K 0]
  double fx_deviation = 0, fy_deviation = 0;  // standard deviations [pixels]
  double cx_deviation = 0, cy_deviation = 0;
  double rms = 0;  // pixels, over all used corners
  std::vector<ViewFit> views;
  std::vector<CornerFit> corners;
  std::vector<std::string> remarks;
};

/// A camera by views of a board (Z. Zhang, PAMI 22(11), 2000; OpenCV's calibrateCamera), again
/// without the views that fit far worse than the others (a board that moved, a wrong corner).
/// @throws DegenerateData as require_views(), or "focal length not determined" when its standard
/// deviation is above 2 %; std::invalid_argument for a bad option.
CameraFit calibrate_camera(const std::vector<BoardView>& views, const CalibrationBoard& board,
                           int width, int height, const CameraOptions& options = {});

}  // namespace prehend::calibration
