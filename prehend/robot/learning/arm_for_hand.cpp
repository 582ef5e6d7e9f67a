#include "prehend/robot/learning/arm_for_hand.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include "prehend/geometry/errors.h"
#include "prehend/robot/learning/hand_file.h"
#include "prehend/robot/link_mesh.h"
#include "prehend/text/yaml_map.h"

namespace prehend::robot::learning {

geometry::RigidTransform mount_on_flange(const LearnedHand& learned) {
  using Eigen::Vector3d;
  const HandModel& hand = learned.hand;
  Vector3d z = Vector3d::Zero(), y = Vector3d::Zero();
  for (const FoundPreshape& found : learned.preshapes) {
    const Eigen::Matrix3d R = hand.X_HP.linear() * found.preshape.X_PG.linear();
    z += found.sure * R.col(2);
    y += found.sure * (R.col(1).dot(y) < 0 ? -1 : 1) * R.col(1);
  }
  geometry::RigidTransform X_FH = geometry::RigidTransform::Identity();
  constexpr double kAlong = 0.966;  // cos 15 deg
  const bool stands = z.normalized().z() > kAlong;
  if (!stands) {
    z.normalize();
    y -= y.dot(z) * z;
    if (!(y.norm() > 1e-6)) y = z.unitOrthogonal();
    y.normalize();
    Eigen::Matrix3d R_HF;
    R_HF << y.cross(z), y, z;
    X_FH.linear() = R_HF.transpose();
  }
  // The palm and what it is mounted on.
  std::vector<geometry::RigidTransform> poses;
  hand.link_poses(hand.all_positions(learned.preshapes.front().preshape.open), poses);
  Eigen::AlignedBox3d box;
  for (std::size_t l = 0; l < poses.size(); ++l) {
    const bool is_finger =
        std::any_of(hand.fingers.begin(), hand.fingers.end(), [&](const Finger& finger) {
          return std::count(finger.links.begin(), finger.links.end(), static_cast<int>(l)) > 0;
        });
    if (is_finger) continue;
    for (const Vector3d& p : link_mesh(hand.model.links[l]).vertices) {
      box.extend(X_FH.linear() * (poses[l] * p));
    }
  }
  if (box.isEmpty()) return X_FH;
  X_FH.translation() = stands ? Vector3d(0, 0, std::max(0.0, -box.min().z()))
                              : -Vector3d(box.center().x(), box.center().y(), box.min().z());
  return X_FH;
}

std::string platform_yaml(const LearnedHand& learned, const std::filesystem::path& platform,
                          const std::filesystem::path& hand, const std::filesystem::path& out) {
  const YAML::Node given = text::load_yaml_map(platform);
  const auto folder = std::filesystem::absolute(out).parent_path();
  YAML::Emitter emitter;
  emitter << YAML::BeginMap << YAML::Key << "name" << YAML::Value << out.stem().string();
  bool has_mount = false;
  for (const auto& entry : given) {
    const std::string key = entry.first.Scalar();
    if (key == "name" || key == "camera") continue;
    emitter << YAML::Key << key << YAML::Value;
    if (key == "arm") {
      const auto arm = std::filesystem::absolute(platform).parent_path() / entry.second.Scalar();
      emitter << std::filesystem::relative(arm, folder).generic_string();
    } else if (key == "hand") {
      emitter
          << std::filesystem::relative(std::filesystem::absolute(hand), folder).generic_string();
    } else if (key == "mount") {
      emitter << YAML::Load(pose_text(mount_on_flange(learned)));
      has_mount = true;
    } else {
      emitter << entry.second;
    }
  }
  if (!has_mount) {
    emitter << YAML::Key << "mount" << YAML::Value
            << YAML::Load(pose_text(mount_on_flange(learned)));
  }
  emitter << YAML::EndMap;
  return fmt::format(
      "# The arm of {} with a learned hand. Keys: prehend/robot/platform.h. The mount is assumed:\n"
      "# the hand's approach along the flange's z.\n{}\n",
      platform.filename().string(), emitter.c_str());
}

}  // namespace prehend::robot::learning
