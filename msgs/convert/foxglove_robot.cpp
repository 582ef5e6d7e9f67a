#include "msgs/convert/foxglove_robot.h"

#include <algorithm>

#include "msgs/convert/foxglove_geometry.h"
#include "prehend/robot/link_mesh.h"

namespace prehend::convert {

::foxglove::SceneUpdate robot_update(const robot::Platform& platform, std::int64_t stamp) {
  ::foxglove::SceneUpdate update;
  for (const robot::Link& link : platform.model.links) {
    if (link.shapes.empty()) continue;
    const bool is_hand = link.name.rfind("hand_", 0) == 0;
    auto& entity = *update.add_entities();
    entity = foxglove_entity("robot/" + link.name, link.name, stamp, true);
    ::foxglove::TriangleListPrimitive& mesh = *entity.add_triangles();
    mesh = foxglove_triangles(robot::link_mesh(link));
    *mesh.mutable_color() =
        is_hand ? foxglove_color(0.35, 0.37, 0.42) : foxglove_color(0.72, 0.74, 0.78);
  }
  return update;
}

std::vector<geometry::RigidTransform> link_poses(const robot::Platform& platform,
                                                 const std::map<std::string, double>& positions) {
  const robot::RobotModel& model = platform.model;
  std::vector<double> at(model.joints.size(), 0);
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const robot::Joint& joint = model.joints[k];
    const auto said = positions.find(joint.name);
    at[k] = said != positions.end() ? said->second : std::clamp(0.0, joint.lower, joint.upper);
  }
  for (std::size_t k = 0; k < model.joints.size(); ++k) {
    const robot::Joint& joint = model.joints[k];
    if (!joint.mimic || positions.count(joint.name) > 0) continue;
    at[k] = joint.mimic->multiplier * at[static_cast<std::size_t>(joint.mimic->joint)] +
            joint.mimic->offset;
  }
  std::vector<geometry::RigidTransform> X_WL(model.links.size(),
                                             geometry::RigidTransform::Identity());
  const auto index = static_cast<std::size_t>(model.link_index(platform.base));
  // The base is where the world has it; the root is the base's or above it.
  std::vector<geometry::RigidTransform> X_RL(model.links.size(),
                                             geometry::RigidTransform::Identity());
  for (std::size_t k = 0; k < model.joints.size(); ++k) {  // parents come before their children
    const robot::Joint& joint = model.joints[k];
    X_RL[static_cast<std::size_t>(joint.child)] =
        X_RL[static_cast<std::size_t>(joint.parent)] * joint.pose_at(at[k]);
  }
  const geometry::RigidTransform X_WR = platform.X_WB * X_RL[index].inverse();
  for (std::size_t i = 0; i < X_RL.size(); ++i) X_WL[i] = X_WR * X_RL[i];
  return X_WL;
}

void add_transform(::foxglove::FrameTransforms& transforms, std::int64_t stamp,
                   const std::string& parent, const std::string& child,
                   const geometry::RigidTransform& X_PC) {
  const ::foxglove::Pose pose = foxglove_pose(X_PC);
  ::foxglove::FrameTransform& transform = *transforms.add_transforms();
  *transform.mutable_timestamp() = foxglove_time(stamp);
  transform.set_parent_frame_id(parent);
  transform.set_child_frame_id(child);
  *transform.mutable_translation() = pose.position();
  *transform.mutable_rotation() = pose.orientation();
}

}  // namespace prehend::convert
