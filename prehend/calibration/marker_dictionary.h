#pragma once

#include <string>

#include <opencv2/aruco.hpp>
#include <opencv2/aruco/charuco.hpp>

#include "prehend/calibration/calibration_board.h"

// What board and detector share of OpenCV's markers.
namespace prehend::calibration {

/// @throws std::invalid_argument naming the nearest there is.
cv::Ptr<cv::aruco::Dictionary> marker_dictionary(CalibrationBoard::Kind kind,
                                                 const std::string& name);

/// @pre a board of markers in a chessboard.
cv::Ptr<cv::aruco::CharucoBoard> charuco_board(const CalibrationBoard& board);

}  // namespace prehend::calibration
