#include <cmath>
#include <string>
#include <vector>

#include "prehend/perception/calibration.h"
#include "prehend/perception/calibration_document.h"

namespace prehend::perception {
namespace {

// One camera_info.
struct CameraInfo {
  int width = 0;
  int height = 0;
  Eigen::Matrix3d K;
  std::vector<double> distortion;
  Eigen::Matrix3d R;              // p_rectified = R p
  Eigen::Matrix<double, 3, 4> P;  // of the rectified image
};

CameraInfo read_camera_info(const std::filesystem::path& path) {
  const CalibrationDocument document(path, read_calibration_text(path));
  CameraInfo info;
  info.width = document.size({"image_width", "width"});
  info.height = document.size({"image_height", "height"});
  info.K = document.matrix({"camera_matrix", "K", "k"});
  check_pinhole(path, info.K, "camera_matrix");
  if (const auto model = document.find({"distortion_model"})) {
    const auto name = model->as<std::string>("");
    if (name != "plumb_bob" && name != "rational_polynomial" && !name.empty()) {
      fail_calibration(path, "has the distortion_model '" + name + "'",
                       "Calibrate with plumb_bob or rational_polynomial");
    }
  }
  if (document.find({"distortion_coefficients", "D", "d"})) {
    info.distortion = document.numbers({"distortion_coefficients", "D", "d"});
    check_distortion(path, info.distortion, "distortion_coefficients");
  }
  info.R = document.matrix({"rectification_matrix", "R", "r"});
  if (!(info.R * info.R.transpose()).isIdentity(1e-3) || info.R.determinant() < 0) {
    fail_calibration(path, "has a 'rectification_matrix' that is not a rotation",
                     "Correct it or calibrate again");
  }
  const std::vector<double> p = document.numbers({"projection_matrix", "P", "p"}, 12);
  info.P = Eigen::Map<const Eigen::Matrix<double, 3, 4, Eigen::RowMajor>>(p.data());
  check_pinhole(path, info.P.leftCols<3>(), "projection_matrix");
  return info;
}

}  // namespace

StereoCalibration read_ros_stereo_calibration(const std::filesystem::path& left,
                                              const std::filesystem::path& right) {
  const CameraInfo l = read_camera_info(left);
  const CameraInfo r = read_camera_info(right);
  if (l.width != r.width || l.height != r.height) {
    fail_calibration(right, "is of another image size than '" + left.string() + "'",
                     "Pass the two files of one stereo camera");
  }
  const double shift = r.P(0, 3) / r.P(0, 0) - l.P(0, 3) / l.P(0, 0);  // -baseline
  if (shift > 0) {
    fail_calibration(right, "is of the left camera (its projection_matrix has a positive Tx)",
                     "Swap the two files");
  }
  check_baseline(right, -shift, "projection_matrix");
  StereoCalibration calibration;
  calibration.width = l.width;
  calibration.height = l.height;
  calibration.K_left = l.K;
  calibration.K_right = r.K;
  calibration.distortion_left = l.distortion;
  calibration.distortion_right = r.distortion;
  // p_rectified_right = p_rectified_left + (shift, 0, 0).
  const Eigen::Matrix3d R_RL = r.R.transpose() * l.R;
  calibration.X_RL = geometry::make_transform(Eigen::Quaterniond(R_RL),
                                              r.R.transpose() * Eigen::Vector3d(shift, 0, 0));
  return calibration;
}

}  // namespace prehend::perception
