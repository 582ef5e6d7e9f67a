#include "prehend/report/robot_meshes.h"

#include <stdexcept>
#include <vector>

#include "prehend/robot/link_mesh.h"

namespace prehend::report {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;

}  // namespace

TriangleMesh robot_mesh(const robot::RobotModel& model,
                        const Eigen::Ref<const Eigen::VectorXd>& positions) {
  if (positions.size() != static_cast<Eigen::Index>(model.joints.size())) {
    throw std::invalid_argument("robot_mesh: one position for each joint of the model");
  }
  std::vector<RigidTransform> X_RL(model.links.size(), RigidTransform::Identity());
  for (std::size_t k = 0; k < model.joints.size(); ++k) {  // parents come before their children
    const robot::Joint& joint = model.joints[k];
    X_RL[joint.child] = X_RL[joint.parent] * joint.pose_at(positions[static_cast<Eigen::Index>(k)]);
  }
  std::vector<TriangleMesh> parts;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    parts.push_back(geometry::transformed(robot::link_mesh(model.links[i]), X_RL[i]));
  }
  return geometry::concatenated(parts);
}

}  // namespace prehend::report
