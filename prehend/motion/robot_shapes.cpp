#include "prehend/motion/robot_shapes.h"

#include "prehend/geometry/errors.h"
#include "prehend/motion/link_places.h"

namespace prehend::motion {
namespace {

using robot::CollisionShape;

ConvexBody convex_body(const CollisionShape& shape) {
  ConvexBody body;
  body.size = shape.size;
  body.radius = shape.radius;
  body.length = shape.length;
  if (shape.kind == CollisionShape::Kind::kSphere) body.kind = ConvexBody::Kind::kSphere;
  if (shape.kind == CollisionShape::Kind::kCylinder) body.kind = ConvexBody::Kind::kCylinder;
  if (shape.kind == CollisionShape::Kind::kMesh) {
    body.kind = ConvexBody::Kind::kPoints;
    body.points = std::make_shared<const std::vector<Eigen::Vector3d>>(
        geometry::convex_hull(shape.solid->vertices).vertices);
  }
  return body;
}

}  // namespace

std::vector<RobotShape> make_robot_shapes(const robot::RobotModel& model, const std::string& base,
                                          const std::string& tip) {
  const robot::KinematicChain chain(model, base, tip);
  const auto places = link_places(model, chain, model.link_index(base));
  std::vector<RobotShape> result;
  for (std::size_t i = 0; i < model.links.size(); ++i) {
    if (!places[i]) continue;
    for (const CollisionShape& shape : model.links[i].shapes) {
      result.push_back({places[i]->joint, places[i]->X_JL * shape.X_LS, convex_body(shape)});
    }
  }
  return result;
}

}  // namespace prehend::motion
