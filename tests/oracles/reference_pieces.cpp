#include "tests/oracles/reference_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>
#include <set>
#include <stdexcept>
#include <utility>

#include <ConvexDecomposition/ConvexBuilder.h>
#include <HACD/hacdHACD.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/solid_hull.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using geometry::TriangleMesh;

/// The cluster of each triangle of `mesh`, by HACD.
std::vector<int> partition(const TriangleMesh& mesh, const HacdOptions& options) {
  constexpr double kScale = 1000;  // to which HACD brings the mesh's diagonal
  std::vector<HACD::Vec3<HACD::Real>> points;
  for (const Eigen::Vector3d& p : mesh.vertices) points.emplace_back(p.x(), p.y(), p.z());
  std::vector<HACD::Vec3<long>> triangles;
  for (const Eigen::Vector3i& t : mesh.triangles) triangles.emplace_back(t.x(), t.y(), t.z());
  HACD::HACD hacd;
  hacd.SetScaleFactor(kScale);
  hacd.SetPoints(points.data());
  hacd.SetNPoints(points.size());
  hacd.SetTriangles(triangles.data());
  hacd.SetNTriangles(triangles.size());
  hacd.SetCompacityWeight(0.1);
  hacd.SetVolumeWeight(0);
  hacd.SetNClusters(1);
  hacd.SetNVerticesPerCH(100);  // of its own hulls, which are not used
  hacd.SetConcavity(options.concavity * kScale);
  hacd.SetConnectDist(options.concavity * kScale);
  hacd.SetAddExtraDistPoints(false);
  hacd.SetAddNeighboursDistPoints(false);
  hacd.SetAddFacesPoints(true);
  if (!hacd.Compute() || hacd.GetPartition() == nullptr) {
    throw InputError("the mesh could not be cut into convex pieces", "give a closed mesh");
  }
  return {hacd.GetPartition(), hacd.GetPartition() + triangles.size()};
}

/// Collects the hulls that ConvexDecomposition hands over.
class HullCollector : public ConvexDecomposition::ConvexDecompInterface {
 public:
  void ConvexDecompResult(ConvexDecomposition::ConvexResult& result) override {
    std::vector<Eigen::Vector3d> points;
    for (unsigned i = 0; i < result.mHullVcount; ++i) {
      const float* p = result.mHullVertices + 3 * i;
      points.emplace_back(p[0], p[1], p[2]);
    }
    if (auto hull = solid_hull(points, 1000)) hulls.push_back(std::move(*hull));
  }
  std::vector<TriangleMesh> hulls;
};

}  // namespace

std::vector<TriangleMesh> hacd_pieces(const TriangleMesh& mesh, const HacdOptions& options) {
  if (options.max_triangles < 50 || !(options.concavity > 0)) {
    throw std::invalid_argument("HacdOptions: max_triangles must be >= 50, concavity > 0");
  }
  if (options.max_hull_vertices < 8 || options.max_hull_vertices > 1000) {
    throw std::invalid_argument("HacdOptions.max_hull_vertices must be in [8, 1000]");
  }
  check_indices_and_vertices(mesh);
  const TriangleMesh coarse = thinned(mesh, options.max_triangles);
  const std::vector<int> clusters = partition(coarse, options);
  // Every vertex of the whole mesh goes to the cluster of the nearest coarse triangle, so that the
  // hulls reach the true surface; the coarse corners tie neighbouring clusters together.
  std::map<int, std::vector<Eigen::Vector3d>> points;
  for (std::size_t i = 0; i < coarse.triangles.size(); ++i) {
    for (const int corner : coarse.triangles[i]) {
      points[clusters[i]].push_back(coarse.vertices[corner]);
    }
  }
  const geometry::MeshQuery query(coarse);
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    if (const auto nearest = query.nearest(vertex)) {
      points[clusters[nearest->triangle]].push_back(vertex);
    }
  }
  std::vector<TriangleMesh> pieces;
  for (const auto& [cluster, of_cluster] : points) {
    auto hull = solid_hull(of_cluster, options.max_hull_vertices);
    if (hull) pieces.push_back(std::move(*hull));
  }
  if (pieces.empty()) throw InputError("the mesh has no volume", "give a closed mesh");
  return pieces;
}

std::vector<TriangleMesh> ratcliff_pieces(const TriangleMesh& mesh, int depth,
                                          double concave_percent) {
  check_indices_and_vertices(mesh);
  // Brought to unit size about the origin: it is written in single precision.
  const Eigen::AlignedBox3d box = geometry::bounds(mesh);
  const double scale = box.diagonal().norm();
  if (!(scale > 0)) throw InputError("the mesh has no volume", "give a closed mesh");
  std::vector<float> vertices;
  for (const Eigen::Vector3d& p : mesh.vertices) {
    for (int k = 0; k < 3; ++k) {
      vertices.push_back(static_cast<float>((p[k] - box.center()[k]) / scale));
    }
  }
  std::vector<unsigned> indices;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) indices.push_back(static_cast<unsigned>(t[k]));
  }
  HullCollector collector;
  ConvexDecomposition::DecompDesc description;
  description.mVcount = static_cast<unsigned>(mesh.vertices.size());
  description.mVertices = vertices.data();
  description.mTcount = static_cast<unsigned>(mesh.triangles.size());
  description.mIndices = indices.data();
  description.mDepth = static_cast<unsigned>(depth);
  description.mCpercent = static_cast<float>(concave_percent);
  description.mPpercent = static_cast<float>(concave_percent);
  description.mMaxVertices = 64;
  description.mCallback = &collector;
  ConvexBuilder(&collector).process(description);
  if (collector.hulls.empty()) throw InputError("the mesh has no volume", "give a closed mesh");
  for (TriangleMesh& hull : collector.hulls) {
    for (Eigen::Vector3d& p : hull.vertices) p = box.center() + scale * p;
  }
  return std::move(collector.hulls);
}

TriangleMesh thinned(const TriangleMesh& mesh, int max_triangles) {
  if (max_triangles < 4) throw std::invalid_argument("thinned: max_triangles must be >= 4");
  if (mesh.triangles.size() <= static_cast<std::size_t>(max_triangles)) return mesh;
  const Eigen::AlignedBox3d box = geometry::bounds(mesh);
  // Two triangles per vertex, one vertex per cell.
  double side = std::sqrt(geometry::surface_area(mesh) / (0.5 * max_triangles));
  if (!(side > 0)) throw InputError("the mesh has no area", "give a mesh with triangles");
  for (;; side *= 1.1) {
    std::map<std::array<std::int64_t, 3>, int> cell_index;
    std::vector<int> cell_of(mesh.vertices.size());
    std::vector<int> count;
    TriangleMesh result;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i) {
      const Eigen::Array3d cell = ((mesh.vertices[i] - box.min()).array() / side).floor();
      const auto [found, is_new] = cell_index.try_emplace(
          {static_cast<std::int64_t>(cell.x()), static_cast<std::int64_t>(cell.y()),
           static_cast<std::int64_t>(cell.z())},
          static_cast<int>(count.size()));
      if (is_new) {
        count.push_back(0);
        result.vertices.push_back(Eigen::Vector3d::Zero());
      }
      cell_of[i] = found->second;
      ++count[found->second];
      result.vertices[found->second] += mesh.vertices[i];
    }
    for (std::size_t i = 0; i < count.size(); ++i) result.vertices[i] /= count[i];
    std::set<std::array<int, 3>> present;
    for (const Eigen::Vector3i& t : mesh.triangles) {
      const Eigen::Vector3i c(cell_of[t.x()], cell_of[t.y()], cell_of[t.z()]);
      if (c.x() == c.y() || c.y() == c.z() || c.z() == c.x()) continue;
      std::array<int, 3> key{c.x(), c.y(), c.z()};
      std::sort(key.begin(), key.end());
      if (present.insert(key).second) result.triangles.push_back(c);
    }
    if (result.triangles.size() <= static_cast<std::size_t>(max_triangles)) return result;
  }
}

}  // namespace prehend::surface
