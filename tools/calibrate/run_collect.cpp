#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/calibration/calibration_space.h"
#include "prehend/calibration/hand_eye_poses.h"
#include "prehend/geometry/errors.h"
#include "prehend/perception/camera_calibration.h"
#include "prehend/perception/image_files.h"
#include "prehend/touch/hand_touch.h"
#include "tools/calibrate/arm_and_camera.h"
#include "tools/calibrate/runs.h"

namespace prehend::tools {
namespace {

using calibration::CameraMount;
using calibration::ChosenPose;
using geometry::InputError;

geometry::RigidTransform pose_of(const std::vector<double>& numbers, const char* what) {
  geometry::RigidTransform X = geometry::RigidTransform::Identity();
  for (const double number : numbers) {
    if (!std::isfinite(number)) {
      throw InputError(std::string(what) + " is not finite", "Write x,y,z,roll,pitch,yaw");
    }
  }
  X.translation() = Eigen::Vector3d(numbers[0], numbers[1], numbers[2]);
  X.linear() = (Eigen::AngleAxisd(numbers[5], Eigen::Vector3d::UnitZ()) *
                Eigen::AngleAxisd(numbers[4], Eigen::Vector3d::UnitY()) *
                Eigen::AngleAxisd(numbers[3], Eigen::Vector3d::UnitX()))
                   .toRotationMatrix();
  return X;
}

calibration::CalibrationSurroundings surroundings_of(const CalibrateChoices& choices) {
  calibration::CalibrationSurroundings around;
  around.mount = hand_eye_options(choices).mount;
  around.guess.X_PC = pose_of(choices.camera_pose, "--camera-pose");
  around.guess.X_QT = pose_of(choices.board_pose, "--board-pose");
  if (!choices.obstacles.empty()) around.table = choices.obstacles.front();
  around.camera_radius = choices.camera_radius;
  around.clearance = choices.clearance;
  return around;
}

calibration::PoseChoice chosen_poses(const CalibrateChoices& choices,
                                     const robot::KinematicChain& chain,
                                     const motion::RobotInWorld& space,
                                     const robot::Positions& start,
                                     const calibration::CalibrationBoard& board,
                                     const perception::CameraCalibration& camera) {
  calibration::PoseChoiceOptions options;
  options.hand_eye = hand_eye_options(choices);
  if (choices.offsets) options.hand_eye.chain = &chain;
  options.poses = choices.poses;
  options.candidates = std::max(options.candidates, 4 * choices.poses);
  options.seed = static_cast<std::uint64_t>(choices.seed);
  const calibration::PoseChoice choice = calibration::choose_poses(
      chain, space, start, surroundings_of(choices).guess, board, camera, options);
  std::printf("%zu poses of %d free ones that see the board, log det of their information %.1f\n",
              choice.poses.size(), choice.candidates, choice.log_det);
  return choice;
}

std::string pose_name(std::size_t index) { return fmt::format("pose_{:02}.png", index + 1); }

// A row of positions after a name; the line of names for both is header_of().
std::string row_of(const std::string& name, const robot::Positions& q) {
  std::string text = "\n" + name;
  for (Eigen::Index j = 0; j < q.size(); ++j) text += fmt::format(",{:.9f}", q[j]);
  return text;
}

std::string header_of(const robot::KinematicChain& chain) {
  std::string text = "image";
  for (const robot::ChainJoint& joint : chain.joints()) text += "," + arm_joint(joint.name);
  return text;
}

perception::CameraCalibration pinhole_calibration(const geometry::PinholeCamera& camera) {
  perception::CameraCalibration calibration;
  calibration.name = "rectified";
  calibration.width = camera.width;
  calibration.height = camera.height;
  calibration.K << camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1;
  calibration.distortion.assign(5, 0.0);
  calibration.P.setZero();
  calibration.P.leftCols<3>() = calibration.K;
  return calibration;
}

// An empty folder for what is recorded.
std::filesystem::path new_folder(const std::string& name) {
  const std::filesystem::path folder(name);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (!std::filesystem::is_directory(folder)) {
    throw InputError(name + " is no folder and cannot become one", "Name another by --out");
  }
  if (!std::filesystem::is_empty(folder)) {
    throw InputError(name + " is not empty", "Name a new folder by --out");
  }
  return folder;
}

Eigen::VectorXd open_hand(const robot::Platform& platform) {
  return platform.hand.all_positions(platform.hand.preshapes.front().open);
}

}  // namespace

void run_calibrate_poses(const CalibrateChoices& choices) {
  const robot::Platform platform = robot::read_platform(choices.platform);
  const robot::KinematicChain chain = platform.arm_chain();
  const calibration::CalibrationBoard board = calibration::read_calibration_board(choices.board);
  const perception::CameraCalibration camera = perception::read_camera_calibration(choices.camera);
  const auto space = calibration::calibration_space(platform, open_hand(platform), board,
                                                    surroundings_of(choices));
  const calibration::PoseChoice choice =
      chosen_poses(choices, chain, *space, platform.home("home").arm, board, camera);
  std::string poses = header_of(chain), ways = poses;
  for (std::size_t i = 0; i < choice.poses.size(); ++i) {
    const ChosenPose& pose = choice.poses[i];
    std::printf("%s: tells %.1f nats, %zu waypoints to it\n", pose_name(i).c_str(), pose.gain,
                pose.path.waypoints.size());
    poses += row_of(pose_name(i), pose.q);
    for (const robot::Positions& q : pose.path.waypoints) ways += row_of(pose_name(i), q);
  }
  if (!choices.out.empty()) write_result(choices.out, poses, "The poses' file");
  if (!choices.ways.empty()) write_result(choices.ways, ways, "The ways' file");
}

void run_calibrate_collect(const CalibrateChoices& choices) {
  const robot::Platform platform = robot::read_platform(choices.platform);
  const robot::KinematicChain chain = platform.arm_chain();
  BoardImages images(choices.board);
  const std::filesystem::path folder = new_folder(choices.out);
  ArmAndCamera robot(choices.registry, chain, choices.patience);
  const perception::CameraCalibration camera = pinhole_calibration(robot.camera());
  const ArmAndCamera::Joints now = robot.joints();
  Eigen::VectorXd hand = open_hand(platform);
  try {
    hand = touch::joint_positions(platform.hand, now.names, now.positions);
  } catch (const std::invalid_argument&) {
    std::printf("/joint_states does not have the hand's joints: it is taken to be open\n");
  }
  const auto space =
      calibration::calibration_space(platform, hand, images.board(), surroundings_of(choices));
  const calibration::PoseChoice choice =
      chosen_poses(choices, chain, *space, now.q, images.board(), camera);
  const std::string camera_file = (folder / "camera.yaml").string();
  write_result(camera_file, perception::camera_calibration_text(camera), "The rectified camera");
  const std::filesystem::path poses_file = folder / "poses.csv";
  std::string rows = header_of(chain);
  HandEyePoses poses(choice.poses.size());
  for (std::size_t i = 0; i < choice.poses.size(); ++i) {
    const ChosenPose& chosen = choice.poses[i];
    try {
      robot.follow(
          motion::Trajectory(chain, chosen.path.waypoints, platform.acceleration, choices.speed));
      const ArmAndCamera::Still still = robot.still_image();
      calibration::HandEyePose pose;
      pose.name = pose_name(i);
      perception::write_color_image(folder / pose.name, still.image);
      pose.view = images.find(still.image, pose.name);
      pose.q = still.q;
      pose.X_BF = chain.forward(still.q);
      rows += row_of(pose.name, still.q);
      poses.add(std::move(pose), images.board().corners());
    } catch (const std::exception& error) {
      // What is there stays useful: `prehend calibrate hand-eye` reads it.
      if (i > 0) write_result(poses_file.string(), rows, "What was recorded until then");
      throw std::runtime_error(
          fmt::format("at pose {} of {}: {}", i + 1, choice.poses.size(), error.what()));
    }
  }
  write_result(poses_file.string(), rows, "The poses' file");
  report_hand_eye(choices, poses.poses(), images.board(), camera, &chain,
                  (folder / "hand_eye.yaml").string(), (folder / "hand_eye.html").string());
}

}  // namespace prehend::tools
