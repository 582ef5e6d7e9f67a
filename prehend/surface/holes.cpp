#include "prehend/surface/holes.h"

#include <map>
#include <set>
#include <utility>
#include <vector>

namespace prehend::surface {
namespace {

using geometry::TriangleMesh;

// Border edges from start to end vertex, against the direction of the triangle they belong to, so
// that a fan along them is turned as its neighbours. Vertices where borders meet are left out.
std::map<int, int> border_edges(const TriangleMesh& mesh) {
  std::set<std::pair<int, int>> directed;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) directed.emplace(t[k], t[(k + 1) % 3]);
  }
  std::map<int, int> next;
  std::set<int> ambiguous;
  for (const auto& [from, to] : directed) {
    if (directed.count({to, from}) != 0) continue;
    if (!next.emplace(to, from).second) ambiguous.insert(to);
  }
  for (const int vertex : ambiguous) next.erase(vertex);
  return next;
}

}  // namespace

ClosedHoles close_holes(TriangleMesh& mesh) {
  ClosedHoles result;
  std::map<int, int> next = border_edges(mesh);
  while (!next.empty()) {
    std::vector<int> loop;
    int vertex = next.begin()->first;
    const int start = vertex;
    for (auto it = next.find(vertex); it != next.end(); it = next.find(vertex)) {
      loop.push_back(vertex);
      vertex = it->second;
      next.erase(it);
    }
    if (vertex != start || loop.size() < 3) continue;  // not a closed loop

    ++result.holes;
    const std::size_t count = loop.size();
    int apex = loop[0];
    if (count > 3) {
      Eigen::Vector3d center = Eigen::Vector3d::Zero();
      for (const int i : loop) center += mesh.vertices[i] / static_cast<double>(count);
      apex = static_cast<int>(mesh.vertices.size());
      mesh.vertices.push_back(center);
    }
    for (std::size_t i = 0; i < count; ++i) {
      const Eigen::Vector3i triangle(apex, loop[i], loop[(i + 1) % count]);
      if (count == 3 && i != 1) continue;  // the loop itself is the triangle
      mesh.triangles.push_back(triangle);
      const Eigen::Vector3d& a = mesh.vertices[triangle[0]];
      result.area +=
          (mesh.vertices[triangle[1]] - a).cross(mesh.vertices[triangle[2]] - a).norm() / 2;
    }
  }
  return result;
}

}  // namespace prehend::surface
