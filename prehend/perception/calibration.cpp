#include "prehend/perception/calibration.h"

#include <cmath>
#include <optional>
#include <sstream>
#include <string>

#include "prehend/geometry/errors.h"
#include "prehend/perception/calibration_document.h"
#include "prehend/perception/camera_calibration.h"

namespace prehend::perception {
namespace {

using geometry::InputError;

void set_baseline(StereoCalibration& calibration, const std::string& place, double baseline) {
  check_baseline(place, baseline, "baseline");
  calibration.X_RL.translation() = Eigen::Vector3d(-baseline, 0, 0);
}

StereoCalibration from_plain_text(const std::filesystem::path& path,
                                  const std::vector<double>& values) {
  if (values.size() != 10) {
    fail_calibration(path, "has " + std::to_string(values.size()) + " numbers, not 10",
                     "Write the nine numbers of K row by row, then the baseline in metres");
  }
  StereoCalibration calibration;
  calibration.K_left =
      Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>(values.data());
  check_pinhole(path, calibration.K_left, "K");
  calibration.K_right = calibration.K_left;
  set_baseline(calibration, path, values[9]);
  return calibration;
}

// The file's numbers if it is nothing but numbers.
std::optional<std::vector<double>> plain_numbers(const std::string& text) {
  std::istringstream stream(text);
  std::vector<double> values;
  for (std::string word; stream >> word;) {
    char* end = nullptr;
    values.push_back(std::strtod(word.c_str(), &end));
    if (end == word.c_str() || *end != '\0') return std::nullopt;
  }
  return values;
}

void read_stereo_pose(const CalibrationDocument& document, StereoCalibration& calibration) {
  const Eigen::Matrix3d R = document.rotation({"R"});
  const std::vector<double> T = document.numbers({"T"}, 3);
  // Printed digits leave R off by a little; the nearest rotation.
  calibration.X_RL = geometry::make_transform(Eigen::Quaterniond(R), {T[0], T[1], T[2]});
  check_baseline(document.place({"T"}), calibration.baseline(), "T");
}

StereoCalibration from_document(const CalibrationDocument& document) {
  const std::filesystem::path& path = document.path();
  StereoCalibration calibration;
  calibration.width = document.size({"width", "image_width"});
  calibration.height = document.size({"height", "image_height"});

  const CalibrationDocument::Names kLeft = {"M1", "K1", "K", "cameraMatrix1", "camera_matrix_left"};
  const CalibrationDocument::Names kRight = {"M2", "K2", "cameraMatrix2", "camera_matrix_right"};
  const CalibrationDocument::Names kLeftDistortion = {"D1", "distCoeffs1", "distortion_left"};
  const CalibrationDocument::Names kRightDistortion = {"D2", "distCoeffs2", "distortion_right"};
  if (!document.find(kLeft)) {  // the plain kind
    if (!document.find({"fx"})) {
      fail_calibration(path, "has neither the key 'fx' nor a matrix 'M1' or 'K'",
                       "Add it or calibrate again");
    }
    calibration.K_left.setIdentity();
    calibration.K_left(0, 0) = document.number({"fx"});
    calibration.K_left(0, 2) = document.number({"cx"});
    calibration.K_left(1, 1) = document.number({"fy"});
    calibration.K_left(1, 2) = document.number({"cy"});
    check_pinhole(document.place({"fx"}), calibration.K_left, "fx, fy");
    calibration.K_right = calibration.K_left;
    set_baseline(calibration, document.place({"baseline"}), document.number({"baseline"}));
    return calibration;
  }
  calibration.K_left = document.matrix(kLeft);
  check_pinhole(document.place(kLeft), calibration.K_left, "M1");
  if (document.find(kLeftDistortion)) {
    calibration.distortion_left = document.numbers(kLeftDistortion);
    check_distortion(document.place(kLeftDistortion), calibration.distortion_left, "D1");
  }
  const bool one_matrix = !document.find(kRight) && document.find({"baseline"});
  if (one_matrix) {
    calibration.K_right = calibration.K_left;
    calibration.distortion_right = calibration.distortion_left;
    set_baseline(calibration, document.place({"baseline"}), document.number({"baseline"}));
    return calibration;
  }
  calibration.K_right = document.matrix(kRight);
  check_pinhole(document.place(kRight), calibration.K_right, "M2");
  if (document.find(kRightDistortion)) {
    calibration.distortion_right = document.numbers(kRightDistortion);
    check_distortion(document.place(kRightDistortion), calibration.distortion_right, "D2");
  }
  read_stereo_pose(document, calibration);
  return calibration;
}

}  // namespace

bool StereoCalibration::is_rectified() const {
  const auto none = [](const std::vector<double>& coefficients) {
    for (const double c : coefficients) {
      if (c != 0) return false;
    }
    return true;
  };
  if (rectification) {  // which may turn and magnify images that correspond already
    const geometry::PinholeCamera& camera = rectification->camera.left;
    Eigen::Matrix3d P;
    P << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
    const bool same = rectification->R_left.isIdentity(1e-9) &&
                      rectification->R_right.isIdentity(1e-9) && P.isApprox(K_left, 1e-9);
    if (!same) return false;
  }
  const Eigen::Vector3d& T = X_RL.translation();
  return none(distortion_left) && none(distortion_right) && K_left.isApprox(K_right, 1e-9) &&
         K_left(0, 1) == 0 && X_RL.linear().isIdentity(1e-9) && T.x() < 0 &&
         T.tail<2>().norm() <= 1e-6 * T.norm();
}

StereoCalibration read_stereo_calibration(const std::filesystem::path& path,
                                          const std::filesystem::path& right) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error)) {
    if (!right.empty()) {
      fail_calibration(path, "is a folder, with which no file of the right camera can go",
                       "Leave '" + right.string() + "' away, or name the left camera's file");
    }
    return read_stereo_calibration(path / "left.yaml", path / "right.yaml");
  }
  if (!right.empty()) {
    const CameraCalibration left_camera = read_camera_calibration(path);
    const CameraCalibration right_camera = read_camera_calibration(right);
    return stereo_calibration(left_camera, right_camera, right.string());
  }
  const std::string text = read_calibration_text(path);
  if (const auto values = plain_numbers(text)) return from_plain_text(path, *values);
  const CalibrationDocument document(path, text);
  if (document.find({"projection_matrix", "P", "p"})) {
    fail_calibration(path, "is the camera_info of one camera",
                     "Name the right camera's file, too, or the folder that has left.yaml and "
                     "right.yaml");
  }
  return from_document(document);
}

geometry::StereoCamera rectified_camera(const StereoCalibration& calibration, int width,
                                        int height) {
  if (!calibration.is_rectified()) {
    throw InputError("The calibration is of cameras that are not rectified",
                     "Rectify the images first");
  }
  if (calibration.width > 0 && calibration.height > 0 &&
      (calibration.width != width || calibration.height != height)) {
    throw InputError("The images are " + std::to_string(width) + " x " + std::to_string(height) +
                         " pixels, the calibration is for " + std::to_string(calibration.width) +
                         " x " + std::to_string(calibration.height),
                     "Pass the calibration of these images");
  }
  geometry::StereoCamera camera;
  const Eigen::Matrix3d& K = calibration.K_left;
  camera.left = {width, height, K(0, 0), K(1, 1), K(0, 2), K(1, 2)};
  camera.baseline = calibration.baseline();
  return camera;
}

}  // namespace prehend::perception
