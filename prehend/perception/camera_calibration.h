#pragma once

#include <filesystem>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "prehend/perception/calibration.h"

// The one format in which a camera's calibration is kept: ROS camera_info YAML, as
// camera_calibration and camera_info_manager of ROS write it
// (http://wiki.ros.org/camera_calibration_parsers; meaning of K, D, R, P:
// sensor_msgs/CameraInfo). A stereo pair is two such files.
namespace prehend::perception {

/// Calibration of one camera C, whose pinhole model has +x right, +y down, +z forward.
struct CameraCalibration {
  std::string name = "camera";  // printable, not empty
  int width = 0;                // pixels
  int height = 0;
  Eigen::Matrix3d K = Eigen::Matrix3d::Identity();  // of the raw image [pixels]
  // k1 k2 p1 p2 [k3 [k4 k5 k6 ...]] of OpenCV; may be empty. Up to five are `plumb_bob`, eight
  // to fourteen `rational_polynomial`.
  std::vector<double> distortion;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();  // p_rectified = R p_C
  // Of the rectified image [pixels]; of the right camera of a pair P(0, 3) = -fx * baseline.
  Eigen::Matrix<double, 3, 4> P = Eigen::Matrix<double, 3, 4>::Zero();

  const char* distortion_model() const;
};

/// A camera that is its own rectified one: P = [K 0], no distortion. @pre width, height > 0.
CameraCalibration ideal_camera(const std::string& name, const geometry::PinholeCamera& camera);

/// The rectified camera: size and left three columns of P.
geometry::PinholeCamera rectified_camera(const CameraCalibration& calibration);

/// Reads camera_info YAML with the keys image_width, image_height, camera_name, camera_matrix,
/// distortion_model, distortion_coefficients, rectification_matrix, projection_matrix (matrices as
/// {rows, cols, data}), or as `rostopic echo` and `ros2 topic echo` print it (width, height, D, K,
/// R, P or d, k, r, p).
/// @throws geometry::InputError "Calibration 'file:line' ..." for what is missing, unknown (with
/// the nearest key), twice, not finite, of another shape, no rotation, no positive focal length, a
/// distortion_model of more or fewer coefficients or a fisheye's (`equidistant`), and for a binned
/// or cut image.
CameraCalibration read_camera_calibration(const std::filesystem::path& path);
/// The same of a text; `path` says in errors where it is from.
CameraCalibration parse_camera_calibration(const std::string& text,
                                           const std::filesystem::path& path);

/// The file's text; numbers have all digits, so that reading gives the same calibration bit by bit.
/// @throws geometry::InputError for a calibration that the reader would refuse.
std::string camera_calibration_text(const CameraCalibration& calibration);
/// Writes it whole or not at all. @throws geometry::InputError as camera_calibration_text, or when
/// the file cannot be written.
void write_camera_calibration(const std::filesystem::path& path,
                              const CameraCalibration& calibration);

/// The pair of two cameras: their relative pose follows from the rectification, p_rectified = R p,
/// and the right projection's P(0, 3) = -fx * baseline. Projections that differ in fx or cx are a
/// valid pair without one rectified camera: the result has no `rectification`.
/// @param right_place names the right camera's file in errors.
/// @throws geometry::InputError for sizes that differ, swapped cameras (says so), rows that do not
/// correspond, cameras one above the other, or a baseline that cannot be.
StereoCalibration stereo_calibration(const CameraCalibration& left, const CameraCalibration& right,
                                     const std::string& right_place = "right camera");

/// The two files' contents of a pair, named left and right, with the rectification that rectify()
/// uses. @throws geometry::InputError as rectification(), and when the size is not known.
std::pair<CameraCalibration, CameraCalibration> camera_calibrations(
    const StereoCalibration& calibration);

}  // namespace prehend::perception
