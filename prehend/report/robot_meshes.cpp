#include "prehend/report/robot_meshes.h"

#include <stdexcept>
#include <vector>

namespace prehend::report {
namespace {

using geometry::RigidTransform;
using geometry::TriangleMesh;
using robot::CollisionShape;

TriangleMesh shape_mesh(const CollisionShape& shape) {
  constexpr int kSegments = 24;
  switch (shape.kind) {
    case CollisionShape::Kind::kBox:
      return geometry::make_box(shape.size);
    case CollisionShape::Kind::kSphere:
      return geometry::make_sphere(shape.radius, kSegments);
    case CollisionShape::Kind::kCylinder:
      return geometry::make_revolution(
          {{shape.radius, -shape.length / 2}, {shape.radius, shape.length / 2}}, kSegments);
    case CollisionShape::Kind::kMesh:
      break;
  }
  return *shape.solid;
}

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
    for (const CollisionShape& shape : model.links[i].shapes) {
      parts.push_back(geometry::transformed(shape_mesh(shape), X_RL[i] * shape.X_LS));
    }
  }
  return geometry::concatenated(parts);
}

}  // namespace prehend::report
