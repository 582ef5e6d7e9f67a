#include "prehend/simulation/shapes.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>
#include <string>
#include <vector>

namespace prehend::simulation {
namespace {

using geometry::TriangleMesh;

constexpr int kSegments = 64;

void require_positive(double value, const char* dimension) {
  if (!(std::isfinite(value) && value > 0)) {
    throw std::invalid_argument(std::string(dimension) + " must be finite and positive");
  }
}

TriangleMesh moved(TriangleMesh mesh, const Eigen::Vector3d& by) {
  for (auto& v : mesh.vertices) v += by;
  return mesh;
}

// A closed tube of radius `radius` along `path`, ends closed by discs.
TriangleMesh make_tube(const std::vector<Eigen::Vector3d>& path, double radius,
                       const Eigen::Vector3d& across) {
  constexpr int kRing = 16;
  TriangleMesh mesh;
  const int rings = static_cast<int>(path.size());
  for (int r = 0; r < rings; ++r) {
    const Eigen::Vector3d tangent =
        (path[std::min(r + 1, rings - 1)] - path[std::max(r - 1, 0)]).normalized();
    const Eigen::Vector3d normal = across.cross(tangent);
    for (int i = 0; i < kRing; ++i) {
      const double angle = 2 * std::numbers::pi * i / kRing;
      mesh.vertices.push_back(path[r] +
                              radius * (std::cos(angle) * normal + std::sin(angle) * -across));
    }
  }
  for (int r = 0; r + 1 < rings; ++r) {
    for (int i = 0; i < kRing; ++i) {
      const int j = (i + 1) % kRing;
      const int a = r * kRing + i, b = r * kRing + j, c = b + kRing, d = a + kRing;
      mesh.triangles.emplace_back(a, c, b);
      mesh.triangles.emplace_back(a, d, c);
    }
  }
  const int start = static_cast<int>(mesh.vertices.size());
  mesh.vertices.push_back(path.front());
  mesh.vertices.push_back(path.back());
  for (int i = 0; i < kRing; ++i) {
    const int j = (i + 1) % kRing, last = (rings - 1) * kRing;
    mesh.triangles.emplace_back(start, i, j);
    mesh.triangles.emplace_back(start + 1, last + j, last + i);
  }
  if (geometry::mass_properties(mesh).volume < 0) {
    for (auto& t : mesh.triangles) std::swap(t[1], t[2]);
  }
  return mesh;
}

}  // namespace

TriangleMesh make_standing_box(const Eigen::Vector3d& size) {
  require_positive(size.minCoeff(), "size");
  return moved(geometry::make_box(size), {0, 0, size.z() / 2});
}

TriangleMesh make_can(double radius, double height) {
  require_positive(radius, "radius");
  require_positive(height, "height");
  const double bevel = std::min({0.002, 0.2 * radius, 0.2 * height});
  return geometry::make_revolution(
      {{radius - bevel, 0}, {radius, bevel}, {radius, height - bevel}, {radius - bevel, height}},
      kSegments);
}

TriangleMesh make_bottle(double radius, double height) {
  require_positive(radius, "radius");
  require_positive(height, "height");
  const double neck = 0.4 * radius, cap = 0.48 * radius;
  const double shoulder = 0.6 * height, neck_start = 0.8 * height, cap_start = 0.88 * height;
  std::vector<Eigen::Vector2d> profile{{0.94 * radius, 0}, {radius, 0.03 * height}};
  constexpr int kShoulderRings = 10;
  for (int i = 0; i <= kShoulderRings; ++i) {
    const double t = static_cast<double>(i) / kShoulderRings;
    const double blend = 0.5 - 0.5 * std::cos(std::numbers::pi * t);
    profile.emplace_back(radius + (neck - radius) * blend, shoulder + (neck_start - shoulder) * t);
  }
  profile.emplace_back(neck, cap_start);
  profile.emplace_back(cap, cap_start + 0.002 * height);
  profile.emplace_back(cap, height);
  return geometry::make_revolution(profile, kSegments);
}

TriangleMesh make_mug(double radius, double height, double wall) {
  require_positive(radius, "radius");
  require_positive(height, "height");
  require_positive(wall, "wall");
  if (wall >= 0.5 * std::min(radius, height)) {
    throw std::invalid_argument("wall must be below half the radius and half the height");
  }
  const TriangleMesh cup = geometry::make_revolution(
      {{radius, 0}, {radius, height}, {radius - wall, height}, {radius - wall, wall}, {0, wall}},
      kSegments);
  // A half ring that ends in the middle of the wall.
  const double handle_radius = 0.32 * height, thickness = std::min(0.005, 0.12 * height);
  std::vector<Eigen::Vector3d> path;
  constexpr int kHandleRings = 16;
  for (int i = 0; i <= kHandleRings; ++i) {
    const double angle = std::numbers::pi * (static_cast<double>(i) / kHandleRings - 0.5);
    path.emplace_back(radius - 0.5 * wall + 0.8 * handle_radius * std::cos(angle), 0,
                      0.52 * height + handle_radius * std::sin(angle));
  }
  return geometry::concatenated({cup, make_tube(path, thickness, Eigen::Vector3d::UnitY())});
}

TriangleMesh make_spray_bottle(double width, double depth, double height) {
  require_positive(width, "width");
  require_positive(depth, "depth");
  require_positive(height, "height");
  const double radius = 0.5 * width, neck = 0.3 * radius;
  const double shoulder = 0.55 * height, neck_start = 0.72 * height, neck_end = 0.84 * height;
  std::vector<Eigen::Vector2d> profile{{0.92 * radius, 0}, {radius, 0.03 * height}};
  constexpr int kShoulderRings = 10;
  for (int i = 0; i <= kShoulderRings; ++i) {
    const double t = static_cast<double>(i) / kShoulderRings;
    const double blend = 0.5 - 0.5 * std::cos(std::numbers::pi * t);
    profile.emplace_back(radius + (neck - radius) * blend, shoulder + (neck_start - shoulder) * t);
  }
  profile.emplace_back(neck, neck_end);
  TriangleMesh body = geometry::make_revolution(profile, kSegments);
  for (auto& v : body.vertices) v.y() *= depth / width;

  const Eigen::Vector3d head_size(0.85 * width, 0.55 * depth, 0.18 * height);
  const TriangleMesh head =
      moved(geometry::make_box(head_size), {0.12 * width, 0, height - 0.5 * head_size.z()});
  const Eigen::Vector3d top(0.4 * width, 0, height - 0.5 * head_size.z());
  const Eigen::Vector3d bottom(0.55 * width, 0, 0.66 * height);
  const TriangleMesh trigger =
      make_tube({top, 0.5 * (top + bottom) + Eigen::Vector3d(0.04 * width, 0, 0), bottom},
                0.06 * width, Eigen::Vector3d::UnitY());
  return geometry::concatenated({body, head, trigger});
}

TriangleMesh make_ball(double radius) {
  require_positive(radius, "radius");
  return moved(geometry::make_sphere(radius, 96), {0, 0, radius});
}

}  // namespace prehend::simulation
