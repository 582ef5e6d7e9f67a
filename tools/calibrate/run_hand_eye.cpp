#include <cmath>
#include <cstdio>
#include <optional>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/calibration/degenerate_data.h"
#include "prehend/calibration/hand_eye.h"
#include "prehend/geometry/errors.h"
#include "prehend/perception/camera_calibration.h"
#include "prehend/report/charts.h"
#include "prehend/robot/platform.h"
#include "tools/calibrate/runs.h"

namespace prehend::tools {
namespace {

using calibration::CameraMount;
using calibration::HandEyeFit;
using calibration::HandEyePose;
using geometry::InputError;

constexpr double kDegrees = 180 / M_PI;

void check_camera(const perception::CameraCalibration& camera, const BoardImages& images,
                  const std::string& file) {
  if (camera.width == images.width() && camera.height == images.height()) return;
  throw InputError(fmt::format("{} is of {} x {} pixels, the images have {} x {}", file,
                               camera.width, camera.height, images.width(), images.height()),
                   "Calibrate the camera at the size at which it is used");
}

// Poses with what the camera saw, and after each what is still missing.
std::vector<HandEyePose> read_poses(const CalibrateChoices& choices, BoardImages& images,
                                    const std::optional<robot::KinematicChain>& chain) {
  const text::CsvTable table = text::read_csv_table(
      choices.inputs.front(), 1, "Write a row for each pose: image,x,y,z,qw,qx,qy,qz");
  const int image = table.require("image", "a file, from this one's folder");
  std::vector<geometry::RigidTransform> flanges;
  std::vector<std::vector<double>> joints;
  if (chain) {
    for (const robot::ChainJoint& joint : chain->joints()) {
      joints.push_back(table.numbers(
          table.require(arm_joint(joint.name), joint.is_revolute ? "the joint's position [rad]"
                                                                 : "the joint's position [m]")));
    }
  } else {
    flanges = poses_of(table);
  }
  HandEyePoses poses(table.rows.size());
  for (std::size_t r = 0; r < table.rows.size(); ++r) {
    HandEyePose pose;
    const std::string& file = table.rows[r][static_cast<std::size_t>(image)];
    pose.view = images.find(beside(table, file));
    pose.name = file;
    if (chain) {
      pose.q.resize(chain->size());
      for (int j = 0; j < chain->size(); ++j) pose.q[j] = joints[static_cast<std::size_t>(j)][r];
      pose.X_BF = chain->forward(pose.q);
    } else {
      pose.X_BF = flanges[r];
    }
    poses.add(std::move(pose), images.board().corners());
  }
  return poses.poses();
}

std::string result_text(const HandEyeFit& fit, CameraMount mount) {
  const bool hand = mount == CameraMount::kHand;
  std::string text = fmt::format(
      "# Found by `prehend calibrate hand-eye`. C: the camera's optical frame, F: the flange, B: "
      "the "
      "arm's\n# base, T: the board (upper left corner, x along its columns, y along its rows).\n"
      "mount: {}\n{}: {}  # +- {:.2g} m, {:.2g} rad\n{}: {}",
      hand ? "hand" : "world", hand ? "X_FC" : "X_BC", pose_text(fit.unknowns.X_PC),
      fit.position_deviation, fit.rotation_deviation, hand ? "X_BT" : "X_FT",
      pose_text(fit.unknowns.X_QT));
  if (fit.offsets.empty()) return text;
  text += "\njoint_offsets:  # true position = said position + offset [rad or m]";
  for (const auto& offset : fit.offsets) {
    text += fmt::format("\n  {}: {:.8f}  # {}", arm_joint(offset.joint), offset.offset,
                        offset.is_free ? fmt::format("+- {:.2g}", offset.deviation)
                                       : "not told from another place of board and camera");
  }
  return text;
}

report::Page residual_page(const HandEyeFit& fit) {
  report::Page page("Hand-eye calibration");
  page.add_paragraph(fmt::format(
      "Camera: {}, standard deviation {:.3f} mm and {:.4f} degrees. Reprojection {:.3f} pixels.",
      pose_text(fit.unknowns.X_PC), 1e3 * fit.position_deviation, fit.rotation_deviation * kDegrees,
      fit.rms));
  report::BarChart position, rotation;
  position.title = "Board seen against predicted";
  position.y_label = "[mm]";
  position.series = {{"position", {}}};
  rotation.title = "The same, turned by";
  rotation.y_label = "[degrees]";
  rotation.series = {{"rotation", {}}};
  std::vector<std::vector<std::string>> rows, solvers, offsets;
  for (std::size_t i = 0; i < fit.poses.size(); ++i) {
    const calibration::HandEyePoseFit& pose = fit.poses[i];
    position.categories.push_back(std::to_string(i + 1));
    position.series[0].values.push_back(pose.used ? 1e3 * pose.position_error : std::nan(""));
    rotation.series[0].values.push_back(pose.used ? kDegrees * pose.rotation_error : std::nan(""));
    rows.push_back({std::to_string(i + 1), pose.name, fmt::format("{:.3f}", pose.rms),
                    fmt::format("{:.3f}", 1e3 * pose.position_error),
                    fmt::format("{:.4f}", kDegrees * pose.rotation_error),
                    pose.used ? "used" : pose.why_not});
  }
  rotation.categories = position.categories;
  page.add_chart(report::draw_bar_chart(position), "Poses by their number in the table below.");
  page.add_chart(report::draw_bar_chart(rotation), "");
  page.add_table({"", "pose", "rms [pixels]", "position [mm]", "rotation [degrees]", ""}, rows);
  page.add_heading("OpenCV's solvers on the poses that agree");
  for (const calibration::SolverAnswer& solver : fit.solvers) {
    if (!solver.unknowns) {
      solvers.push_back({solver.method, "failed", "", ""});
      continue;
    }
    const geometry::RigidTransform off = fit.unknowns.X_PC.inverse() * solver.unknowns->X_PC;
    solvers.push_back({solver.method, fmt::format("{:.3f}", solver.rms),
                       fmt::format("{:.3f}", 1e3 * off.translation().norm()),
                       fmt::format("{:.4f}", kDegrees * Eigen::AngleAxisd(off.linear()).angle())});
  }
  page.add_table({"solver", "rms [pixels]", "from the refined [mm]", "[degrees]"}, solvers);
  for (const calibration::JointOffset& offset : fit.offsets) {
    offsets.push_back(
        {arm_joint(offset.joint), fmt::format("{:.6f}", offset.offset),
         offset.is_free ? fmt::format("{:.2g}", offset.deviation) : "not determined"});
  }
  if (!offsets.empty()) {
    page.add_heading("Zero offsets of the joints");
    page.add_table({"joint", "offset [rad or m]", "standard deviation"}, offsets);
  }
  return page;
}

}  // namespace

calibration::HandEyeOptions hand_eye_options(const CalibrateChoices& choices) {
  calibration::HandEyeOptions options;
  options.mount = choices.mount == "hand" ? CameraMount::kHand : CameraMount::kWorld;
  options.pixel_noise = choices.pixel_noise;
  options.position_noise = choices.position_noise;
  options.rotation_noise = choices.rotation_noise;
  return options;
}

void HandEyePoses::add(HandEyePose pose, int corners) {
  std::string missing = "nothing is missing";
  if (!pose.view.ids.empty()) seen_.push_back(pose.X_BF);
  try {
    calibration::require_motions(seen_);
  } catch (const calibration::DegenerateData& error) {
    missing = "missing: " + error.problem();
  }
  poses_.push_back(std::move(pose));
  std::printf("%zu of %zu  %s: %zu of %d corners; %s\n", poses_.size(), wanted_,
              poses_.back().name.c_str(), poses_.back().view.ids.size(), corners, missing.c_str());
  std::fflush(stdout);
}

std::string arm_joint(const std::string& joint) {
  return joint.rfind("arm_", 0) == 0 ? joint.substr(4) : joint;
}

void run_calibrate_hand_eye(const CalibrateChoices& choices) {
  if (choices.inputs.size() != 1) throw std::invalid_argument("give one CSV file of poses");
  if (choices.offsets && choices.platform.empty()) {
    throw InputError("--offsets needs the joints' positions", "Name the arm by --platform");
  }
  BoardImages images(choices.board);
  const perception::CameraCalibration camera = perception::read_camera_calibration(choices.camera);
  std::optional<robot::KinematicChain> chain;
  if (!choices.platform.empty()) chain = robot::read_platform(choices.platform).arm_chain();
  const std::vector<HandEyePose> poses = read_poses(choices, images, chain);
  check_camera(camera, images, choices.camera);
  report_hand_eye(choices, poses, images.board(), camera, chain ? &*chain : nullptr, choices.out,
                  page_file(choices));
}

void report_hand_eye(const CalibrateChoices& choices, const std::vector<HandEyePose>& poses,
                     const calibration::CalibrationBoard& board,
                     const perception::CameraCalibration& camera,
                     const robot::KinematicChain* chain, const std::string& out,
                     const std::string& page) {
  calibration::HandEyeOptions options = hand_eye_options(choices);
  if (choices.offsets) options.chain = chain;
  const HandEyeFit fit = calibration::calibrate_hand_eye(poses, board, camera, options);
  for (const calibration::SolverAnswer& solver : fit.solvers) {
    std::printf("solver %-10s %s\n", solver.method.c_str(),
                solver.unknowns ? fmt::format("{:.3f} pixels", solver.rms).c_str() : "failed");
  }
  std::printf("camera %s: %s +- %.3f mm, %.4f degrees; %.3f pixels of reprojection\n",
              choices.mount == "hand" ? "on the flange" : "in the base's frame",
              pose_text(fit.unknowns.X_PC).c_str(), 1e3 * fit.position_deviation,
              fit.rotation_deviation * kDegrees, fit.rms);
  for (const auto& pose : fit.poses) {
    if (!pose.used) std::printf("  left out: %s: %s\n", pose.name.c_str(), pose.why_not.c_str());
  }
  for (const auto& offset : fit.offsets) {
    std::printf("  offset of %s: %.6f%s\n", arm_joint(offset.joint).c_str(), offset.offset,
                offset.is_free ? fmt::format(" +- {:.2g}", offset.deviation).c_str()
                               : ", not told from another place of board and camera");
  }
  if (!page.empty()) write_page(page, residual_page(fit));
  if (!out.empty()) write_result(out, result_text(fit, options.mount), "The hand-eye calibration");
}

}  // namespace prehend::tools
