#include "prehend/robot/formats/collada_solid.h"

#include <algorithm>
#include <cmath>

#include <Eigen/Geometry>

#include "prehend/robot/formats/collada_elements.h"
#include "prehend/robot/formats/shape_mesh.h"

namespace prehend::robot::formats {
namespace {

XmlElement part_of_solid(const XmlElement& solid, const char* name) {
  auto part = solid.child(name);
  if (!part) solid.fail("the " + solid.name() + " has no " + name, "Give it");
  return *part;
}

}  // namespace

std::optional<Shape> collada_solid(const XmlElement& element, double length) {
  Shape shape;
  shape.X_LS = collada_steps(element, length);
  if (const auto box = element.child("box")) {
    const auto n = part_of_solid(*box, "half_extents").text_numbers(3);
    shape.size = 2 * length * Eigen::Vector3d(n[0], n[1], n[2]);
    return shape;
  }
  if (const auto plane = element.child("plane")) {
    const XmlElement equation = part_of_solid(*plane, "equation");
    const auto n = equation.text_numbers(4);
    const Eigen::Vector3d normal(n[0], n[1], n[2]);
    if (!(normal.norm() > 1e-9)) equation.fail("the plane has no normal", "Give it");
    shape.kind = Shape::Kind::kPlane;
    shape.X_LS.translate(-length * n[3] / normal.squaredNorm() * normal);
    shape.X_LS.rotate(Eigen::Quaterniond::FromTwoVectors(Eigen::Vector3d::UnitZ(), normal));
    return shape;
  }
  for (const char* kind : {"sphere", "cylinder", "capsule"}) {
    const auto round = element.child(kind);
    if (!round) continue;
    const XmlElement radius = part_of_solid(*round, "radius");
    const auto radii = radius.text_numbers(0);
    if (radii.empty()) radius.fail("it has no number", "Give one");
    shape.radius = length * *std::max_element(radii.begin(), radii.end());
    shape.kind = Shape::Kind::kSphere;
    if (std::string(kind) == "sphere") return shape;
    shape.kind = std::string(kind) == "cylinder" ? Shape::Kind::kCylinder : Shape::Kind::kCapsule;
    shape.length = length * part_of_solid(*round, "height").text_number();
    return shape;
  }
  return std::nullopt;
}

bool has_inside(const Shape& solid) {
  const auto is_size = [](double size) { return size > 0 && std::isfinite(size); };
  switch (solid.kind) {
    case Shape::Kind::kBox:
      return is_size(solid.size.minCoeff()) && solid.size.allFinite();
    case Shape::Kind::kSphere:
      return is_size(solid.radius);
    case Shape::Kind::kCylinder:
      return is_size(solid.radius) && is_size(solid.length);
    case Shape::Kind::kCapsule:
      return is_size(solid.radius) && std::isfinite(solid.length) && solid.length >= 0;
    default:
      return false;
  }
}

bool is_same_solid(const Shape& solid, const geometry::TriangleMesh& mesh) {
  if (!has_inside(solid) || mesh.vertices.empty()) return false;
  const auto own = geometry::bounds(geometry::transformed(ShapeMeshes("").of(solid), solid.X_LS));
  const auto given = geometry::bounds(mesh);
  const double most = 0.01 * own.sizes().maxCoeff();
  return (own.min() - given.min()).cwiseAbs().maxCoeff() <= most &&
         (own.max() - given.max()).cwiseAbs().maxCoeff() <= most;
}

}  // namespace prehend::robot::formats
