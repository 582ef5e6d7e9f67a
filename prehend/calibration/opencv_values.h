#pragma once

#include <vector>

#include <Eigen/Core>
#include <opencv2/core.hpp>

#include "prehend/calibration/board_view.h"
#include "prehend/calibration/calibration_board.h"
#include "prehend/geometry/rigid_transform.h"

// The library's values as OpenCV's, for the files of this folder that call it.
namespace prehend::calibration {

cv::Mat matrix_of(const Eigen::Matrix3d& matrix);
Eigen::Matrix3d eigen_of(const cv::Mat& matrix);
std::vector<double> numbers_of(const cv::Mat& numbers);
geometry::RigidTransform transform_of(const cv::Vec3d& rotation, const cv::Vec3d& translation);

/// The view's corners on the board [m, in T], and in the image [pixels].
std::vector<cv::Point3f> board_points(const BoardView& view, const CalibrationBoard& board);
std::vector<cv::Point2f> view_pixels(const BoardView& view);

/// Whether the view's corners lie on one line of the board, which gives no homography.
bool is_in_line(const BoardView& view, const CalibrationBoard& board);

}  // namespace prehend::calibration
