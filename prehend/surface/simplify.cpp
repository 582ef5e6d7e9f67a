#include "prehend/surface/simplify.h"

#include <algorithm>
#include <cstdint>
#include <future>
#include <limits>
#include <vector>

#include <meshoptimizer.h>

#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/deviation.h"
#include "prehend/surface/edge_cuts.h"

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

geometry::TriangleMesh collapsed(const geometry::TriangleMesh& mesh, std::size_t triangles) {
  const Arrays arrays = arrays_of(mesh);
  std::vector<std::uint32_t> kept(arrays.indices.size());
  kept.resize(meshopt_simplify(kept.data(), arrays.indices.data(), arrays.indices.size(),
                               arrays.positions.data(), mesh.vertices.size(), 3 * sizeof(float),
                               3 * triangles, std::numeric_limits<float>::max(), 0, nullptr));
  geometry::TriangleMesh result;
  std::vector<int> place(mesh.vertices.size(), -1);
  for (std::size_t i = 0; i + 2 < kept.size(); i += 3) {
    Eigen::Vector3i triangle;
    for (int k = 0; k < 3; ++k) {
      const std::uint32_t old = kept[i + static_cast<std::size_t>(k)];
      if (place[old] < 0) {
        place[old] = static_cast<int>(result.vertices.size());
        result.vertices.push_back(mesh.vertices[old]);
      }
      triangle[k] = place[old];
    }
    result.triangles.push_back(triangle);
  }
  return result;
}

/// What the deviation from another mesh takes of a mesh.
struct Measured {
  explicit Measured(const geometry::TriangleMesh& mesh)
      : surface(mesh), points(sample_surface(mesh, kErrorPoints, 1)) {}
  geometry::MeshQuery surface;
  std::vector<Eigen::Vector3d> points;
};

}  // namespace

SimplifiedMesh simplified(const geometry::TriangleMesh& mesh, std::size_t most_triangles) {
  // Formats without shared vertices repeat them; an edge between copies cannot be collapsed.
  const double extent = geometry::bounds(mesh).sizes().maxCoeff();
  const geometry::TriangleMesh merged = geometry::with_merged_vertices(mesh, 1e-7 * extent);
  if (merged.triangles.size() <= most_triangles) return {merged, 0};
  // Half of the time is that of the mesh's queries, made meanwhile.
  auto measuring = std::async(std::launch::async, [&merged] { return Measured(merged); });
  SimplifiedMesh result{collapsed(merged, most_triangles), 0};
  if (!geometry::find_defects(result.mesh).watertight()) {
    result.mesh = with_cut_edges(result.mesh);
  }
  const Measured fewer(result.mesh);
  const Measured whole = measuring.get();
  result.error = std::max(deviation(whole.points, fewer.surface).max,
                          deviation(fewer.points, whole.surface).max);
  return result;
}

}  // namespace prehend::surface
