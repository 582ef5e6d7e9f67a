#pragma once

#include <string>
#include <vector>

#include "prehend/calibration/calibrate_camera.h"
#include "prehend/perception/calibration.h"

namespace prehend::calibration {

/// What both cameras saw at one moment.
struct StereoView {
  BoardView left, right;
};

/// How well a pair fits, in the common fit.
struct PairFit {
  int view = 0;                        // index
  int corners = 0;                     // that both cameras see
  double left_rms = 0, right_rms = 0;  // pixels
};

struct StereoFit {
  perception::StereoCalibration calibration;
  CameraFit left, right;       // each alone; the calibration's are fitted together
  std::vector<PairFit> pairs;  // that are used
  double rms = 0;              // pixels, over the corners that both cameras see
  /// Pixels: by how much the rows of a corner differ in the rectified pair, root mean square.
  double row_rms = 0;
};

/// Two cameras and their relative pose: each camera alone, then all together over the corners that
/// both see (OpenCV's stereoCalibrate, from the single cameras' values on).
/// @throws DegenerateData as calibrate_camera(), with the camera's name; "too few views" when fewer
/// than four pairs have six corners in common; "board symmetric" for a board that looks the same
/// upside down; "pairs disagree" when both fit together far worse than alone; "cameras exchanged"
/// when the left one stands to the right.
StereoFit calibrate_stereo(const std::vector<StereoView>& views, const CalibrationBoard& board,
                           int width, int height, const CameraOptions& options = {});

}  // namespace prehend::calibration
