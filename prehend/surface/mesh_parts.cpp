#include "prehend/surface/mesh_parts.h"

#include <algorithm>
#include <numeric>
#include <vector>

namespace prehend::surface {

geometry::TriangleMesh solid_parts(const geometry::TriangleMesh& mesh, double least_share) {
  if (mesh.empty()) return {};
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const Eigen::Vector3i& t : mesh.triangles) {
    // To the lower index, so that roots do not depend on the order of the triangles.
    for (const int corner : {t.y(), t.z()}) {
      const int a = root(t.x());
      const int b = root(corner);
      parent[std::max(a, b)] = std::min(a, b);
    }
  }
  // About a point near the mesh, so that a mesh far from the origin loses no digits.
  const Eigen::Vector3d reference = mesh.vertices[mesh.triangles.front()[0]];
  std::vector<double> volume(mesh.vertices.size(), 0), area(mesh.vertices.size(), 0);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d a = mesh.vertices[t.x()] - reference;
    const Eigen::Vector3d b = mesh.vertices[t.y()] - reference;
    const Eigen::Vector3d c = mesh.vertices[t.z()] - reference;
    volume[root(t.x())] += a.dot(b.cross(c)) / 6;
    area[root(t.x())] += (b - a).cross(c - a).norm() / 2;
  }
  const double largest = *std::max_element(volume.begin(), volume.end());
  const double widest = *std::max_element(area.begin(), area.end());
  const auto stays = [&](int part) {
    return volume[part] > 0 &&
           (volume[part] >= least_share * largest || area[part] >= 2 * least_share * widest);
  };

  geometry::TriangleMesh parts;
  std::vector<int> renumbered(mesh.vertices.size(), -1);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    if (!stays(root(t.x()))) continue;
    Eigen::Vector3i triangle;
    for (int corner = 0; corner < 3; ++corner) {
      int& index = renumbered[t(corner)];
      if (index < 0) {
        index = static_cast<int>(parts.vertices.size());
        parts.vertices.push_back(mesh.vertices[t(corner)]);
      }
      triangle(corner) = index;
    }
    parts.triangles.push_back(triangle);
  }
  return parts;
}

}  // namespace prehend::surface
