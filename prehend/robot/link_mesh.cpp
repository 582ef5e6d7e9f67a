#include "prehend/robot/link_mesh.h"

#include <vector>

namespace prehend::robot {
namespace {

geometry::TriangleMesh shape_mesh(const CollisionShape& shape) {
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

geometry::TriangleMesh link_mesh(const Link& link) {
  std::vector<geometry::TriangleMesh> parts;
  for (const CollisionShape& shape : link.shapes) {
    parts.push_back(geometry::transformed(shape_mesh(shape), shape.X_LS));
  }
  return geometry::concatenated(parts);
}

}  // namespace prehend::robot
