#include "prehend/surface/simplify.h"

#include <cstdint>
#include <limits>
#include <vector>

#include <meshoptimizer.h>

namespace prehend::surface {

namespace {

// The simplifier's input, made once.
struct Arrays {
  std::vector<float> positions;
  std::vector<std::uint32_t> indices;
};

Arrays arrays_of(const geometry::TriangleMesh& mesh) {
  Arrays arrays;
  arrays.positions.reserve(3 * mesh.vertices.size());
  for (const Eigen::Vector3d& p : mesh.vertices) {
    for (int k = 0; k < 3; ++k) arrays.positions.push_back(static_cast<float>(p[k]));
  }
  arrays.indices.reserve(3 * mesh.triangles.size());
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) arrays.indices.push_back(static_cast<std::uint32_t>(t[k]));
  }
  return arrays;
}

SimplifiedMesh collapsed(const geometry::TriangleMesh& mesh, const Arrays& arrays,
                         std::size_t triangles) {
  constexpr std::size_t kStride = 3 * sizeof(float);
  std::vector<std::uint32_t> kept(arrays.indices.size());
  float relative_error = 0;
  kept.resize(meshopt_simplify(kept.data(), arrays.indices.data(), arrays.indices.size(),
                               arrays.positions.data(), mesh.vertices.size(), kStride,
                               3 * triangles, std::numeric_limits<float>::max(), 0,
                               &relative_error));
  SimplifiedMesh result;
  result.error = static_cast<double>(relative_error) *
                 static_cast<double>(
                     meshopt_simplifyScale(arrays.positions.data(), mesh.vertices.size(), kStride));
  std::vector<int> place(mesh.vertices.size(), -1);
  for (std::size_t i = 0; i + 2 < kept.size(); i += 3) {
    Eigen::Vector3i triangle;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t old = kept[i + static_cast<std::size_t>(k)];
      if (place[old] < 0) {
        place[old] = static_cast<int>(result.mesh.vertices.size());
        result.mesh.vertices.push_back(mesh.vertices[old]);
      }
      triangle[k] = place[old];
    }
    result.mesh.triangles.push_back(triangle);
  }
  return result;
}

}  // namespace

SimplifiedMesh simplified(const geometry::TriangleMesh& mesh, std::size_t most_triangles) {
  // Formats without shared vertices repeat them; an edge between copies cannot be collapsed.
  const double extent = geometry::bounds(mesh).sizes().maxCoeff();
  const geometry::TriangleMesh merged = geometry::with_merged_vertices(mesh, 1e-7 * extent);
  if (merged.triangles.size() <= most_triangles) return {merged, 0};
  const Arrays arrays = arrays_of(merged);
  const bool closed = geometry::find_defects(merged).watertight();
  for (const std::size_t more : {1, 2, 4}) {
    SimplifiedMesh fewer = collapsed(merged, arrays, more * most_triangles);
    if (!closed || geometry::find_defects(fewer.mesh).watertight()) return fewer;
  }
  return {merged, 0};
}

}  // namespace prehend::surface
