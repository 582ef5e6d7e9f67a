#include <cmath>
#include <numbers>
#include <stdexcept>

#include "prehend/geometry/triangle_mesh.h"

namespace prehend::geometry {

TriangleMesh make_box(const Eigen::Vector3d& size) {
  if (!(size.minCoeff() > 0)) throw std::invalid_argument("a box needs side lengths > 0 m");
  TriangleMesh mesh;
  for (int i = 0; i < 8; ++i) {
    mesh.vertices.emplace_back((i & 1 ? 0.5 : -0.5) * size.x(), (i & 2 ? 0.5 : -0.5) * size.y(),
                               (i & 4 ? 0.5 : -0.5) * size.z());
  }
  // Corner index = x + 2 y + 4 z.
  constexpr int kQuads[6][4] = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4},
                                {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  for (const auto& q : kQuads) {
    mesh.triangles.emplace_back(q[0], q[1], q[2]);
    mesh.triangles.emplace_back(q[0], q[2], q[3]);
  }
  return mesh;
}

TriangleMesh make_revolution(const std::vector<Eigen::Vector2d>& profile, int segments) {
  if (profile.size() < 2) throw std::invalid_argument("a revolution needs two profile points");
  if (segments < 3) throw std::invalid_argument("a revolution needs three segments");
  TriangleMesh mesh;
  std::vector<int> ring_start;  // first vertex of each ring; apexes have one vertex
  std::vector<bool> is_apex;
  // A disc closes an open end: its centre is an apex at the same height.
  std::vector<Eigen::Vector2d> rings = profile;
  if (rings.front().x() > 0) rings.insert(rings.begin(), {0.0, rings.front().y()});
  if (rings.back().x() > 0) rings.emplace_back(0.0, rings.back().y());
  for (const auto& ring : rings) {
    if (!(ring.x() >= 0)) throw std::invalid_argument("a revolution's radii must be >= 0 m");
    ring_start.push_back(static_cast<int>(mesh.vertices.size()));
    is_apex.push_back(ring.x() == 0);
    const int count = is_apex.back() ? 1 : segments;
    for (int i = 0; i < count; ++i) {
      const double angle = 2 * std::numbers::pi * i / segments;
      mesh.vertices.emplace_back(ring.x() * std::cos(angle), ring.x() * std::sin(angle), ring.y());
    }
  }
  for (std::size_t r = 0; r + 1 < rings.size(); ++r) {
    for (int i = 0; i < segments; ++i) {
      const int j = (i + 1) % segments;
      const int a = ring_start[r] + (is_apex[r] ? 0 : i);
      const int b = ring_start[r] + (is_apex[r] ? 0 : j);
      const int c = ring_start[r + 1] + (is_apex[r + 1] ? 0 : j);
      const int d = ring_start[r + 1] + (is_apex[r + 1] ? 0 : i);
      if (a != b) mesh.triangles.emplace_back(a, b, c);
      if (c != d) mesh.triangles.emplace_back(a, c, d);
    }
  }
  return mesh;
}

TriangleMesh make_sphere(double radius, int segments) {
  if (!(radius > 0)) throw std::invalid_argument("a sphere needs a radius > 0 m");
  std::vector<Eigen::Vector2d> profile;
  const int rings = std::max(2, segments / 2);
  for (int i = 0; i <= rings; ++i) {
    const double angle = std::numbers::pi * i / rings;
    const bool pole = i == 0 || i == rings;
    profile.emplace_back(pole ? 0.0 : radius * std::sin(angle), -radius * std::cos(angle));
  }
  return make_revolution(profile, segments);
}

}  // namespace prehend::geometry
