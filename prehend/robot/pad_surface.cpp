#include "prehend/robot/pad_surface.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <utility>

#include "prehend/contact/shape.h"
#include "prehend/geometry/errors.h"

namespace prehend::robot {
namespace {

constexpr double kSamePlace = 1e-6;   // of the extent: vertices nearer to one another are one
constexpr double kLongestRegion = 1;  // m
constexpr double kWithin = 0.45;      // of a cell's side: another one there is in its place
constexpr double kSameSide = 0.5;     // cosine between their normals

contact::Shape solid_of(const CollisionShape& shape) {
  switch (shape.kind) {
    case CollisionShape::Kind::kBox:
      return contact::Shape::box(shape.size);
    case CollisionShape::Kind::kSphere:
      return contact::Shape::sphere(shape.radius);
    case CollisionShape::Kind::kCylinder:
      return contact::Shape::cylinder(shape.radius, shape.length);
    case CollisionShape::Kind::kMesh:
      return contact::Shape::mesh(*shape.solid);
  }
  throw std::logic_error("a CollisionShape of no kind");
}

}  // namespace

contact::PadLayout lay_on_link(const Link& link, const geometry::RigidTransform& X_LP,
                               const contact::PadGrid& grid, double raised,
                               const std::vector<Eigen::Vector2i>& left_out) {
  if (link.shapes.empty()) {
    throw std::invalid_argument("link '" + link.name + "' has no collision shape to lay a pad on");
  }
  std::vector<std::pair<contact::Shape, geometry::RigidTransform>> solids;  // X_SP
  for (const CollisionShape& shape : link.shapes) {
    solids.emplace_back(solid_of(shape), shape.X_LS.inverse() * X_LP);
  }
  const double above = 0.5 * std::max(grid.width, grid.length);
  const auto surface = [&](double x, double y) -> std::optional<double> {
    double first = std::numeric_limits<double>::infinity();
    for (const auto& [solid, X_SP] : solids) {
      first =
          std::min(first, solid.ray_distance(X_SP * Eigen::Vector3d(x, y, above),
                                             X_SP.linear() * -Eigen::Vector3d::UnitZ(), 2 * above));
    }
    // What begins inside has no surface there.
    if (!(first > 0) || !std::isfinite(first)) return std::nullopt;
    return above - first + raised;
  };
  return contact::PadLayout::bent(grid, surface, left_out);
}

contact::PadLayout cells_of_region(const PadRegion& region, double thickness) {
  geometry::TriangleMesh mesh = geometry::read_mesh_region(region.file, region.region);
  for (Eigen::Vector3d& p : mesh.vertices) p = region.X_LS * p.cwiseProduct(region.scale);
  if (region.scale.prod() < 0) {
    for (Eigen::Vector3i& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  const double extent = geometry::bounds(mesh).sizes().maxCoeff();
  if (extent > kLongestRegion) {
    throw geometry::InputError("the pad's region of '" + region.file.string() + "' is " +
                                   std::to_string(extent) + " m long at its scale",
                               "Of a mesh in millimetres write scale: 0.001");
  }
  if (extent > 0) mesh = geometry::with_merged_vertices(mesh, kSamePlace * extent);
  return contact::PadLayout::curved(mesh, thickness);
}

std::string overlap(const HandPad& a, const HandPad& b) {
  if (a.link != b.link) return "";
  const geometry::RigidTransform X_AB = a.X_LP.inverse() * b.X_LP;
  for (std::size_t j = 0; j < b.layout->size(); ++j) {
    if (b.layout->area(j) == 0) continue;
    const Eigen::Vector3d p = X_AB * b.layout->position(j), n = X_AB.linear() * b.layout->normal(j);
    for (std::size_t i = 0; i < a.layout->size(); ++i) {
      if (a.layout->area(i) == 0) continue;
      const double side = std::sqrt(std::max(a.layout->area(i), b.layout->area(j)));
      if ((p - a.layout->position(i)).norm() >= kWithin * side) continue;
      if (n.dot(a.layout->normal(i)) <= kSameSide) continue;
      const Eigen::Vector3d p_L = a.X_LP * a.layout->position(i);
      return "'" + a.name + "' and '" + b.name + "' overlap at (" + std::to_string(p_L.x()) + ", " +
             std::to_string(p_L.y()) + ", " + std::to_string(p_L.z()) + ") m of their link";
    }
  }
  return "";
}

}  // namespace prehend::robot
