#include "prehend/calibration/opencv_values.h"

#include <algorithm>

#include <opencv2/calib3d.hpp>

namespace prehend::calibration {

cv::Mat matrix_of(const Eigen::Matrix3d& matrix) {
  cv::Mat made(3, 3, CV_64F);
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) made.at<double>(r, c) = matrix(r, c);
  }
  return made;
}

Eigen::Matrix3d eigen_of(const cv::Mat& matrix) {
  Eigen::Matrix3d made;
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) made(r, c) = matrix.at<double>(r, c);
  }
  return made;
}

std::vector<double> numbers_of(const cv::Mat& numbers) {
  cv::Mat row;
  numbers.reshape(1, 1).convertTo(row, CV_64F);
  return {row.begin<double>(), row.end<double>()};
}

geometry::RigidTransform transform_of(const cv::Vec3d& rotation, const cv::Vec3d& translation) {
  cv::Mat R;
  cv::Rodrigues(rotation, R);
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  X.linear() = eigen_of(R);
  X.translation() = Eigen::Vector3d(translation[0], translation[1], translation[2]);
  return X;
}

std::vector<cv::Point3f> board_points(const BoardView& view, const CalibrationBoard& board) {
  std::vector<cv::Point3f> points;
  for (const int id : view.ids) {
    const Eigen::Vector3f p = board.corner_T(id).cast<float>();
    points.emplace_back(p.x(), p.y(), p.z());
  }
  return points;
}

std::vector<cv::Point2f> view_pixels(const BoardView& view) {
  std::vector<cv::Point2f> pixels;
  for (const Eigen::Vector2d& p : view.pixels) {
    pixels.emplace_back(static_cast<float>(p.x()), static_cast<float>(p.y()));
  }
  return pixels;
}

bool is_in_line(const BoardView& view, const CalibrationBoard& board) {
  Eigen::Matrix2d spread = Eigen::Matrix2d::Zero();
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();
  for (const int id : view.ids) mean += board.corner_T(id).head<2>() / double(view.ids.size());
  for (const int id : view.ids) {
    const Eigen::Vector2d d = board.corner_T(id).head<2>() - mean;
    spread += d * d.transpose();
  }
  // Of a line the smaller eigenvalue is nothing.
  const double trace = spread.trace();
  return !(spread.determinant() > 1e-4 * trace * trace);
}

}  // namespace prehend::calibration
