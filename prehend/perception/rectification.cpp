#include "prehend/perception/rectification.h"

#include <cmath>
#include <limits>
#include <string>
#include <utility>

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

// Where each pixel of the rectified image is in the raw one, in OpenCV's fixed point.
struct ImageRectifier::Maps {
  int width = 0;
  int height = 0;
  cv::Mat places;     // CV_16SC2, rounded down
  cv::Mat fractions;  // CV_16UC1, of a pixel
  cv::Mat nearest;    // CV_16SC2, rounded
};

ImageRectifier::ImageRectifier(const Eigen::Matrix3d& K, const std::vector<double>& distortion,
                               const Eigen::Matrix3d& R, const geometry::PinholeCamera& rectified) {
  Eigen::Matrix3d P;
  P << rectified.fx, 0, rectified.cx, 0, rectified.fy, rectified.cy, 0, 0, 1;
  auto maps = std::make_shared<Maps>();
  maps->width = rectified.width;
  maps->height = rectified.height;
  cv::Mat x;
  cv::Mat y;
  cv::initUndistortRectifyMap(matrix(K), column(distortion), matrix(R), matrix(P),
                              cv::Size(rectified.width, rectified.height), CV_32FC1, x, y);
  cv::Mat none;
  cv::convertMaps(x, y, maps->places, maps->fractions, CV_16SC2, false);
  cv::convertMaps(x, y, maps->nearest, none, CV_16SC2, true);
  maps_ = std::move(maps);
}

void ImageRectifier::check_size(int width, int height) const {
  if (width == maps_->width && height == maps_->height) return;
  throw InputError("The images are " + std::to_string(width) + " x " + std::to_string(height) +
                       " pixels, the calibration is for " + std::to_string(maps_->width) + " x " +
                       std::to_string(maps_->height),
                   "Pass the calibration of these images");
}

ColorImage ImageRectifier::operator()(const ColorImage& image) const {
  check_size(image.width, image.height);
  ColorImage result(image.width, image.height);
  cv::Mat target = view(result);
  cv::remap(view(image), target, maps_->places, maps_->fractions, cv::INTER_LINEAR);
  return result;
}

geometry::DepthImage ImageRectifier::operator()(const geometry::DepthImage& depth) const {
  check_size(depth.width, depth.height);
  geometry::DepthImage result(depth.width, depth.height);
  const cv::Mat source(depth.height, depth.width, CV_32F, const_cast<float*>(depth.data.data()));
  cv::Mat target(depth.height, depth.width, CV_32F, result.data.data());
  cv::remap(source, target, maps_->nearest, cv::Mat(), cv::INTER_NEAREST, cv::BORDER_CONSTANT,
            std::numeric_limits<float>::quiet_NaN());
  return result;
}

PairRectifier::PairRectifier(const StereoCalibration& calibration, int width, int height) {
  const StereoRectification rectified = rectification(calibration, width, height);
  camera_ = rectified.camera;
  if (calibration.is_rectified()) return;
  left_.emplace(calibration.K_left, calibration.distortion_left, rectified.R_left, camera_.left);
  right_.emplace(calibration.K_right, calibration.distortion_right, rectified.R_right,
                 camera_.left);
}

RectifiedPair PairRectifier::operator()(const ColorImage& left, const ColorImage& right) const {
  if (left.empty() || left.width != right.width || left.height != right.height) {
    throw InputError("Left and right image differ in size or are empty",
                     "Pass the two images of one instant");
  }
  if (left.width != camera_.left.width || left.height != camera_.left.height) {
    throw InputError("The images are " + std::to_string(left.width) + " x " +
                         std::to_string(left.height) + " pixels, not " +
                         std::to_string(camera_.left.width) + " x " +
                         std::to_string(camera_.left.height),
                     "Pass the calibration of these images");
  }
  if (!left_) return {left, right, camera_};
  return {(*left_)(left), (*right_)(right), camera_};
}

RectifiedPair rectify(const ColorImage& left, const ColorImage& right,
                      const StereoCalibration& calibration) {
  if (left.empty()) {
    throw InputError("The left image is empty", "Pass the two images of one instant");
  }
  return PairRectifier(calibration, left.width, left.height)(left, right);
}

}  // namespace prehend::perception
