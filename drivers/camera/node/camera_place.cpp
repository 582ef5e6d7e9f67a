#include "drivers/camera/node/camera_place.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Geometry>

#include "msgs/convert/joint_positions.h"
#include "prehend/geometry/errors.h"
#include "prehend/robot/robot_files.h"
#include "prehend/text/tree_file.h"

namespace prehend::drivers::camera {
namespace {

geometry::RigidTransform pose_of(const std::vector<double>& pose) {
  const bool is_finite =
      std::all_of(pose.begin(), pose.end(), [](double value) { return std::isfinite(value); });
  constexpr std::size_t kValues = 7;
  if (pose.size() != kValues || !is_finite) {
    throw geometry::InputError("Parameter pose is not seven numbers",
                               "Write x y z [m] qw qx qy qz of the camera in the world");
  }
  const Eigen::Quaterniond q(pose[3], pose[4], pose[5], pose[6]);
  if (std::abs(q.norm() - 1) > 1e-3) {
    throw geometry::InputError("Parameter pose has a quaternion whose norm is not 1",
                               "Write x y z [m] qw qx qy qz, w first");
  }
  return geometry::make_transform(q, {pose[0], pose[1], pose[2]});
}

}  // namespace

CameraPlace::CameraPlace(graph::Node& node) {
  const auto pose = node.declare_parameter<std::vector<double>>(
      {.name = "pose",
       .description = "of the (left) camera's optical frame in the world: x y z [m] qw qx qy qz; "
                      "none: the world is made from the table",
       .read_only = true});
  const auto file = node.declare_parameter<std::string>(
      {.name = "platform",
       .description = "the robot whose arm carries the camera (kr5_sdh_camera, or a file with "
                      "`camera`): each picture says where it was taken, by /joint_states; empty: "
                      "the camera stands still",
       .read_only = true});
  const auto folder = node.declare_parameter<std::string>(
      {.name = "platforms",
       .default_value = text::tree_file("config/robots"),
       .description = "folder of the platforms that have names, NAME.yaml",
       .read_only = true});
  if (!pose.empty()) X_WC_ = pose_of(pose);
  if (file.empty()) return;
  if (X_WC_) {
    throw geometry::InputError(
        "Parameters pose and platform both say where the camera is",
        "Give pose to a camera that stands still, platform to one on an arm");
  }
  platform_ = robot::read_platform(robot::platform_file(folder, file));
  if (!platform_->X_FC) {
    throw geometry::InputError(
        "Parameter platform: the arm of " + platform_->name + " carries no camera",
        "Write `camera: {xyz: ..., rpy: ...}` into its file, where the "
        "(left) optical frame is on the flange, or give pose");
  }
  joints_ = node.subscribe<msgs::JointState>(
      "/joint_states", graph::QoS::queue(100),
      [this](const graph::Received<msgs::JointState>& joints) { hear(*joints); });
}

void CameraPlace::hear(const msgs::JointState& joints) {
  auto now = convert::positions_of(platform_->arm_chain(), joints);
  if (!now) return;
  const std::lock_guard lock(mutex_);
  history_.add(joints.header().stamp(), *std::move(now));
}

std::optional<geometry::RigidTransform> CameraPlace::at(std::int64_t stamp) const {
  if (!platform_) return std::nullopt;
  std::optional<robot::Positions> arm;
  {
    const std::lock_guard lock(mutex_);
    arm = history_.at(stamp);
  }
  if (!arm) {
    throw geometry::InputError(
        "Where the arm was when a picture was taken is not known",
        "Start who publishes /joint_states of " + platform_->name + ", on the same clock");
  }
  return platform_->X_WC(*arm);
}

}  // namespace prehend::drivers::camera
