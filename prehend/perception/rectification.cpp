#include "prehend/perception/rectification.h"

#include <cmath>
#include <string>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "prehend/geometry/errors.h"

namespace prehend::perception {
namespace {

using geometry::ColorImage;
using geometry::InputError;

cv::Mat view(const ColorImage& image) {
  return {image.height, image.width, CV_8UC3,
          const_cast<void*>(static_cast<const void*>(image.data.data()))};
}

cv::Mat matrix(const Eigen::Matrix3d& m) {
  cv::Mat result(3, 3, CV_64F);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) result.at<double>(i, j) = m(i, j);
  }
  return result;
}

cv::Mat column(const std::vector<double>& values) {
  return cv::Mat(values, true).reshape(1, static_cast<int>(values.size()));
}

ColorImage remapped(const ColorImage& image, const cv::Mat& K, const cv::Mat& distortion,
                    const cv::Mat& rotation, const cv::Mat& projection) {
  cv::Mat map_x;
  cv::Mat map_y;
  cv::initUndistortRectifyMap(K, distortion, rotation, projection,
                              cv::Size(image.width, image.height), CV_32FC1, map_x, map_y);
  ColorImage result(image.width, image.height);
  cv::Mat target = view(result);
  cv::remap(view(image), target, map_x, map_y, cv::INTER_LINEAR);
  return result;
}

}  // namespace

StereoRectification rectification(const StereoCalibration& calibration, int width, int height) {
  const bool sized = calibration.width > 0 && calibration.height > 0;
  if (sized && (calibration.width != width || calibration.height != height)) {
    throw InputError("The images are " + std::to_string(width) + " x " + std::to_string(height) +
                         " pixels, the calibration is for " + std::to_string(calibration.width) +
                         " x " + std::to_string(calibration.height),
                     "Pass the calibration of these images");
  }
  if (calibration.rectification) return *calibration.rectification;
  StereoRectification result;
  if (calibration.is_rectified()) {
    result.camera = rectified_camera(calibration, width, height);
    return result;
  }
  const Eigen::Vector3d& T = calibration.X_RL.translation();
  if (std::abs(T.y()) > std::abs(T.x()) || T.x() >= 0) {
    throw InputError(
        "The right camera is not to the right of the left one (T = " + std::to_string(T.x()) +
            ", " + std::to_string(T.y()) + ", " + std::to_string(T.z()) + " m)",
        "Swap the two images and calibrate in that order");
  }
  cv::Mat R_left;
  cv::Mat R_right;
  cv::Mat P_left;
  cv::Mat P_right;
  cv::Mat Q;
  cv::stereoRectify(matrix(calibration.K_left), column(calibration.distortion_left),
                    matrix(calibration.K_right), column(calibration.distortion_right),
                    cv::Size(width, height), matrix(calibration.X_RL.linear()),
                    column({T.x(), T.y(), T.z()}), R_left, R_right, P_left, P_right, Q,
                    cv::CALIB_ZERO_DISPARITY, 0.0);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) {
      result.R_left(i, j) = R_left.at<double>(i, j);
      result.R_right(i, j) = R_right.at<double>(i, j);
    }
  }
  geometry::PinholeCamera& camera = result.camera.left;
  camera.width = width;
  camera.height = height;
  camera.fx = P_left.at<double>(0, 0);
  camera.fy = P_left.at<double>(1, 1);
  camera.cx = P_left.at<double>(0, 2);
  camera.cy = P_left.at<double>(1, 2);
  result.camera.baseline = -P_right.at<double>(0, 3) / P_right.at<double>(0, 0);
  if (!std::isfinite(camera.fx) || camera.fx <= 0 || !(result.camera.baseline > 0)) {
    throw InputError("The calibration cannot be rectified", "Calibrate the cameras again");
  }
  return result;
}

RectifiedPair rectify(const ColorImage& left, const ColorImage& right,
                      const StereoCalibration& calibration) {
  if (left.empty() || left.width != right.width || left.height != right.height) {
    throw InputError("Left and right image differ in size or are empty",
                     "Pass the two images of one instant");
  }
  const StereoRectification rectified = rectification(calibration, left.width, left.height);
  if (calibration.is_rectified()) return {left, right, rectified.camera};
  const geometry::PinholeCamera& camera = rectified.camera.left;
  Eigen::Matrix3d P;
  P << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  RectifiedPair pair;
  pair.left = remapped(left, matrix(calibration.K_left), column(calibration.distortion_left),
                       matrix(rectified.R_left), matrix(P));
  pair.right = remapped(right, matrix(calibration.K_right), column(calibration.distortion_right),
                        matrix(rectified.R_right), matrix(P));
  pair.camera = rectified.camera;
  return pair;
}

}  // namespace prehend::perception
