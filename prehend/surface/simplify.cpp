#include "prehend/surface/simplify.h"

#include <algorithm>
#include <cstdint>
#include <future>
#include <limits>
#include <span>
#include <vector>

#include <meshoptimizer.h>

#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/deviation.h"
#include "prehend/surface/edge_cuts.h"

namespace prehend::surface {
namespace {

using Indices = std::vector<std::uint32_t>;  // three a triangle

// The simplifier's input.
struct Arrays {
  std::vector<float> positions;  // three a vertex
  Indices indices;

  std::size_t vertices() const { return positions.size() / 3; }
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

// About `triangles` of the mesh's, with its vertices.
Indices collapsed(const Arrays& arrays, std::size_t triangles, unsigned options) {
  Indices kept(arrays.indices.size());
  kept.resize(meshopt_simplify(kept.data(), arrays.indices.data(), arrays.indices.size(),
                               arrays.positions.data(), arrays.vertices(), 3 * sizeof(float),
                               3 * triangles, std::numeric_limits<float>::max(), options, nullptr));
  return kept;
}

// Some triangles of a mesh, with no vertices but theirs.
struct Part {
  Arrays arrays;
  Indices vertices;  // of the part: which of the mesh's each is
};

// Makes parts of one mesh; each costs what it holds, not what the mesh holds.
class PartMaker {
 public:
  explicit PartMaker(const Arrays& whole) : whole_(whole), place_(whole.vertices(), kNowhere) {}

  Part part(std::span<const std::uint32_t> indices) {
    Part part;
    for (const std::uint32_t vertex : indices) {
      if (place_[vertex] == kNowhere) {
        place_[vertex] = static_cast<std::uint32_t>(part.vertices.size());
        part.vertices.push_back(vertex);
        for (std::size_t k = 0; k < 3; ++k) {
          part.arrays.positions.push_back(whole_.positions[3 * vertex + k]);
        }
      }
      part.arrays.indices.push_back(place_[vertex]);
    }
    for (const std::uint32_t vertex : part.vertices) place_[vertex] = kNowhere;
    return part;
  }

 private:
  static constexpr std::uint32_t kNowhere = std::numeric_limits<std::uint32_t>::max();
  const Arrays& whole_;
  Indices place_;  // in the part of the mesh's vertices
};

// About `triangles` of the mesh's, collapsed in parts that fit the processor's cache and keep their
// borders: half the time of the whole at once.
Indices thinned(const Arrays& whole, std::size_t triangles) {
  constexpr std::size_t kPart = 3 * 32'768;  // indices
  Indices sorted(whole.indices.size());
  meshopt_spatialSortTriangles(sorted.data(), whole.indices.data(), whole.indices.size(),
                               whole.positions.data(), whole.vertices(), 3 * sizeof(float));
  const double share =
      static_cast<double>(3 * triangles) / static_cast<double>(whole.indices.size());
  PartMaker parts(whole);
  Indices kept;
  for (std::size_t first = 0; first < sorted.size(); first += kPart) {
    const std::size_t size = std::min(kPart, sorted.size() - first);
    const Part part = parts.part({sorted.data() + first, size});
    const auto wanted = static_cast<std::size_t>(share * static_cast<double>(size / 3));
    for (const std::uint32_t i : collapsed(part.arrays, wanted, meshopt_SimplifyLockBorder)) {
      kept.push_back(part.vertices[i]);
    }
  }
  return kept;
}

geometry::TriangleMesh collapsed(const geometry::TriangleMesh& mesh, std::size_t triangles) {
  constexpr std::size_t kAhead = 6;  // times the triangles that are wanted, before the last ones
  Arrays whole = arrays_of(mesh);
  if (mesh.triangles.size() > 2 * kAhead * triangles) {
    whole.indices = thinned(whole, kAhead * triangles);
  }
  const Part rest = PartMaker(whole).part(whole.indices);
  const Indices indices = collapsed(rest.arrays, triangles, 0);
  geometry::TriangleMesh result;
  const Part kept = PartMaker(rest.arrays).part(indices);
  for (const std::uint32_t i : kept.vertices) {
    result.vertices.push_back(mesh.vertices[rest.vertices[i]]);
  }
  for (std::size_t i = 0; i + 2 < kept.arrays.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) { return static_cast<int>(kept.arrays.indices[i + k]); };
    result.triangles.emplace_back(corner(0), corner(1), corner(2));
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
