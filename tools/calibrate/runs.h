#pragma once

#include <string>
#include <vector>

#include "prehend/calibration/calibrate_camera.h"
#include "prehend/calibration/hand_eye.h"
#include "prehend/geometry/image.h"
#include "prehend/geometry/rigid_transform.h"
#include "prehend/report/page.h"
#include "prehend/text/csv_table.h"
#include "tools/calibrate/choices.h"

// What the commands of `prehend calibrate` do. Each throws std::exception with one clear line.
namespace prehend::tools {

void run_calibrate_camera(const CalibrateChoices& choices);
void run_calibrate_stereo(const CalibrateChoices& choices);
void run_calibrate_hand_eye(const CalibrateChoices& choices);
void run_calibrate_poses(const CalibrateChoices& choices);
void run_calibrate_collect(const CalibrateChoices& choices);
void run_calibrate_table(const CalibrateChoices& choices);
void run_calibrate_wrench(const CalibrateChoices& choices);
void run_calibrate_board(const CalibrateChoices& choices);

/// Files as given, of folders their images by name. @throws geometry::InputError for what is not
/// there, or a folder without images.
std::vector<std::string> image_files(const std::vector<std::string>& inputs);

/// Mount and noises.
calibration::HandEyeOptions hand_eye_options(const CalibrateChoices& choices);

/// A joint of a platform's arm as the arm's file calls it: without arm_ before it.
std::string arm_joint(const std::string& joint);

/// Poses of the arm with what the camera saw, one after the other, and after each what is still
/// missing.
class HandEyePoses {
 public:
  explicit HandEyePoses(std::size_t wanted) : wanted_(wanted) {}
  /// @param corners of the whole board
  void add(calibration::HandEyePose pose, int corners);
  const std::vector<calibration::HandEyePose>& poses() const { return poses_; }

 private:
  const std::size_t wanted_;
  std::vector<calibration::HandEyePose> poses_;
  std::vector<geometry::RigidTransform> seen_;  // X_BF of those that show the board
};

/// Fits, prints, and writes result and page of residuals; empty names: not. @param chain of the
/// arm, for --offsets; else it may be null.
void report_hand_eye(const CalibrateChoices& choices,
                     const std::vector<calibration::HandEyePose>& poses,
                     const calibration::CalibrationBoard& board,
                     const perception::CameraCalibration& camera,
                     const robot::KinematicChain* chain, const std::string& out,
                     const std::string& page);

/// A board in images of one size, one after the other.
class BoardImages {
 public:
  explicit BoardImages(const std::string& board_file);

  const calibration::CalibrationBoard& board() const { return board_; }
  /// @throws geometry::InputError when the image cannot be read or is of another size than the
  /// first.
  calibration::BoardView find(const std::string& file);
  calibration::BoardView find(const geometry::ColorImage& image, const std::string& name);
  int width() const { return width_; }
  int height() const { return height_; }

 private:
  calibration::CalibrationBoard board_;
  std::string first_;
  int width_ = 0, height_ = 0;
};

/// X_AB from columns x, y, z, qw, qx, qy, qz of a row. @throws geometry::InputError "file:line:
/// ..." for a quaternion that is none.
std::vector<geometry::RigidTransform> poses_of(const text::CsvTable& table);
/// R_AB from qw, qx, qy, qz.
std::vector<Eigen::Matrix3d> rotations_of(const text::CsvTable& table);

/// "{xyz: [...], rpy: [...]}" as robot::read_pose() reads it.
std::string pose_text(const geometry::RigidTransform& X);

/// Where a file of the table's column is: from the table's folder.
std::string beside(const text::CsvTable& table, const std::string& name);

/// Where the page of residuals goes: --report, else beside the result; empty without both.
std::string page_file(const CalibrateChoices& choices);

/// Writes the text whole, making its folder, and says so.
void write_result(const std::string& file, const std::string& text, const char* what);
void write_page(const std::string& file, const report::Page& page);

/// What a camera's views leave: their errors as bars, the residuals as points, where in the image
/// corners were.
void add_camera_residuals(report::Page& page, const calibration::CameraFit& fit);

}  // namespace prehend::tools
