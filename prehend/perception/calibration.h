#pragma once

#include <filesystem>
#include <optional>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/camera_model.h"
#include "prehend/geometry/rigid_transform.h"

namespace prehend::perception {

/// Rotations that turn two cameras' images into a rectified pair, and the camera of that pair.
struct StereoRectification {
  Eigen::Matrix3d R_left = Eigen::Matrix3d::Identity();  // p_rectified = R_left p_L
  Eigen::Matrix3d R_right = Eigen::Matrix3d::Identity();
  geometry::StereoCamera camera;
};

/// Calibration of two cameras L (left) and R (right) with lens distortion, as OpenCV's
/// stereoCalibrate gives it.
struct StereoCalibration {
  int width = 0;  // pixels; 0 when the file does not say
  int height = 0;
  Eigen::Matrix3d K_left = Eigen::Matrix3d::Identity();  // pinhole matrices [pixels]
  Eigen::Matrix3d K_right = Eigen::Matrix3d::Identity();
  std::vector<double> distortion_left;  // k1 k2 p1 p2 [k3 [k4 k5 k6 ...]] of OpenCV; may be empty
  std::vector<double> distortion_right;
  geometry::RigidTransform X_RL = geometry::RigidTransform::Identity();  // p_R = X_RL p_L
  /// How its images are rectified, where the files say it; otherwise rectification() chooses.
  std::optional<StereoRectification> rectification;

  double baseline() const { return X_RL.translation().norm(); }  // m
  /// True when the images need no rectification: no distortion, equal pinhole matrices, no relative
  /// rotation, the right camera displaced along +x only.
  bool is_rectified() const;
};

/// Reads a stereo calibration. What is understood, by its content:
///  - ROS camera_info YAML (camera_calibration.h) of the left camera at `path` and of the right one
///    at `right`; or a folder that has both as left.yaml and right.yaml;
///  - OpenCV YAML with matrices M1, D1, M2, D2, R, T (also named K1/K2, cameraMatrix1/2,
///    distCoeffs1/2), or with one matrix K (M1 alone) and `baseline`; optional width and height or
///    image_width/image_height;
///  - plain YAML {width, height, fx, fy, cx, cy, baseline};
///  - text: the nine numbers of K row by row, then the baseline.
/// Lengths are metres. @throws geometry::InputError that names the file, where known the line, the
/// key and the mend for a missing or foreign file, a missing key, a zero or negative baseline or
/// focal length, NaN, or a baseline over 10 m (millimetres?).
StereoCalibration read_stereo_calibration(const std::filesystem::path& path,
                                          const std::filesystem::path& right = {});

/// The camera of a rectified calibration for images of the given size [pixels].
/// @throws geometry::InputError when the calibration is not rectified or states another size.
geometry::StereoCamera rectified_camera(const StereoCalibration& calibration, int width,
                                        int height);

}  // namespace prehend::perception
