#include "tests/grasp/hand_scene.h"

#include <cmath>
#include <numbers>

namespace prehend::grasp {

geometry::TriangleMesh make_torus(double radius, double thickness, int around, int across) {
  geometry::TriangleMesh mesh;
  const auto index = [&](int i, int j) { return (i % around) * across + j % across; };
  for (int i = 0; i < around; ++i) {
    for (int j = 0; j < across; ++j) {
      const double a = 2 * std::numbers::pi * i / around, b = 2 * std::numbers::pi * j / across;
      const double r = radius + thickness * std::cos(b);
      mesh.vertices.emplace_back(r * std::cos(a), r * std::sin(a), thickness * std::sin(b));
      mesh.triangles.emplace_back(index(i, j), index(i + 1, j), index(i + 1, j + 1));
      mesh.triangles.emplace_back(index(i, j), index(i + 1, j + 1), index(i, j + 1));
    }
  }
  return mesh;
}

}  // namespace prehend::grasp
