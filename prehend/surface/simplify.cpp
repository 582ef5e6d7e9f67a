#include "prehend/surface/simplify.h"

#include <cstdint>
#include <limits>
#include <vector>

#include <meshoptimizer.h>

namespace prehend::surface {

SimplifiedMesh simplified(const geometry::TriangleMesh& mesh, std::size_t most_triangles) {
  // Formats without shared vertices repeat them; an edge between copies cannot be collapsed.
  const double extent = geometry::bounds(mesh).sizes().maxCoeff();
  const geometry::TriangleMesh merged = geometry::with_merged_vertices(mesh, 1e-7 * extent);
  if (merged.triangles.size() <= most_triangles) return {merged, 0};
  std::vector<float> positions;
  positions.reserve(3 * merged.vertices.size());
  for (const Eigen::Vector3d& p : merged.vertices) {
    for (int k = 0; k < 3; ++k) positions.push_back(static_cast<float>(p[k]));
  }
  std::vector<std::uint32_t> indices, kept;
  indices.reserve(3 * merged.triangles.size());
  for (const Eigen::Vector3i& t : merged.triangles) {
    for (int k = 0; k < 3; ++k) indices.push_back(static_cast<std::uint32_t>(t[k]));
  }
  kept.resize(indices.size());
  constexpr std::size_t kStride = 3 * sizeof(float);
  float relative_error = 0;
  kept.resize(meshopt_simplify(kept.data(), indices.data(), indices.size(), positions.data(),
                               merged.vertices.size(), kStride, 3 * most_triangles,
                               std::numeric_limits<float>::max(), 0, &relative_error));
  SimplifiedMesh result;
  result.error =
      static_cast<double>(relative_error) *
      static_cast<double>(meshopt_simplifyScale(positions.data(), merged.vertices.size(), kStride));
  std::vector<int> place(merged.vertices.size(), -1);
  for (std::size_t i = 0; i + 2 < kept.size(); i += 3) {
    Eigen::Vector3i triangle;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t old = kept[i + static_cast<std::size_t>(k)];
      if (place[old] < 0) {
        place[old] = static_cast<int>(result.mesh.vertices.size());
        result.mesh.vertices.push_back(merged.vertices[old]);
      }
      triangle[k] = place[old];
    }
    result.mesh.triangles.push_back(triangle);
  }
  return result;
}

}  // namespace prehend::surface
