#include "prehend/surface/convex_pieces.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <iostream>
#include <map>
#include <optional>
#include <set>
#include <stdexcept>
#include <string>

#include <HACD/hacdHACD.h>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/surface/deviation.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using geometry::TriangleMesh;

void check(const ConvexPiecesOptions& options) {
  const auto require = [](bool condition, const std::string& what) {
    if (!condition) throw std::invalid_argument("ConvexPiecesOptions." + what);
  };
  require(options.max_triangles >= 50, "max_triangles must be >= 50");
  require(options.concavity > 0 && std::isfinite(options.concavity), "concavity must be > 0");
  require(options.min_pieces >= 1, "min_pieces must be >= 1");
  require(options.max_hull_vertices >= 4 && options.max_hull_vertices <= 1000,
          "max_hull_vertices must be in [4, 1000]");
}

void check(const TriangleMesh& mesh) {
  if (mesh.empty()) throw InputError("the mesh has no triangles", "give a closed mesh");
  for (const Eigen::Vector3d& vertex : mesh.vertices) {
    if (!vertex.allFinite()) {
      throw InputError("the mesh has vertices that are not finite", "give a closed mesh");
    }
  }
  for (const Eigen::Vector3i& t : mesh.triangles) {
    if (t.minCoeff() < 0 || t.maxCoeff() >= static_cast<int>(mesh.vertices.size())) {
      throw InputError("the mesh has triangle indices out of range", "give a closed mesh");
    }
  }
}

/// HACD reports its progress on std::cout; this keeps it quiet for a while.
class QuietStandardOutput {
 public:
  QuietStandardOutput() : buffer_(std::cout.rdbuf(nullptr)) {}
  ~QuietStandardOutput() {
    std::cout.rdbuf(buffer_);
    std::cout.clear();
  }
  QuietStandardOutput(const QuietStandardOutput&) = delete;
  QuietStandardOutput& operator=(const QuietStandardOutput&) = delete;

 private:
  std::streambuf* buffer_;
};

/// The cluster of each triangle of `mesh`, by HACD.
std::vector<int> partition(const TriangleMesh& mesh, const ConvexPiecesOptions& options) {
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
  hacd.SetNClusters(options.min_pieces);
  hacd.SetNVerticesPerCH(100);  // of its own hulls, which are not used
  hacd.SetConcavity(options.concavity * kScale);
  hacd.SetConnectDist(options.concavity * kScale);
  hacd.SetAddExtraDistPoints(false);
  hacd.SetAddNeighboursDistPoints(false);
  hacd.SetAddFacesPoints(true);
  bool computed = false;
  {
    const QuietStandardOutput quiet;
    computed = hacd.Compute();
  }
  if (!computed || hacd.GetPartition() == nullptr) {
    throw InputError("the mesh could not be cut into convex pieces", "give a closed mesh");
  }
  return {hacd.GetPartition(), hacd.GetPartition() + triangles.size()};
}

/// Convex hull with at most `max_vertices`, the extreme points along as many directions spread over
/// the sphere; none when the points have no volume.
std::optional<TriangleMesh> solid_hull(const std::vector<Eigen::Vector3d>& points,
                                       std::size_t max_vertices) {
  if (points.size() < 4) return std::nullopt;
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const Eigen::Vector3d& p : points) mean += p;
  mean /= static_cast<double>(points.size());
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (const Eigen::Vector3d& p : points) covariance += (p - mean) * (p - mean).transpose();
  const double largest = covariance.trace();
  if (!(largest > 0) || !((covariance / largest).determinant() > 1e-12)) return std::nullopt;

  TriangleMesh hull = geometry::convex_hull(points);
  if (hull.vertices.size() <= max_vertices) return hull;
  std::set<std::size_t> chosen;
  const double golden = 2.399963229728653;  // rad, golden angle
  for (std::size_t i = 0; i < max_vertices; ++i) {
    const double z = 1 - (2 * i + 1.0) / static_cast<double>(max_vertices);
    const double r = std::sqrt(1 - z * z);
    const Eigen::Vector3d direction(r * std::cos(golden * i), r * std::sin(golden * i), z);
    std::size_t best = 0;
    for (std::size_t j = 1; j < hull.vertices.size(); ++j) {
      if (direction.dot(hull.vertices[j]) > direction.dot(hull.vertices[best])) best = j;
    }
    chosen.insert(best);
  }
  std::vector<Eigen::Vector3d> extremes;
  for (const std::size_t i : chosen) extremes.push_back(hull.vertices[i]);
  return geometry::convex_hull(extremes);
}

/// Deepest distance from the hull to the mesh, measured at points spread over the hull [m].
double hull_concavity(const TriangleMesh& mesh, const TriangleMesh& hull) {
  return deviation(sample_surface(hull, 2000, 1), geometry::MeshQuery(mesh)).max;
}

}  // namespace

std::vector<TriangleMesh> convex_pieces(const TriangleMesh& mesh,
                                        const ConvexPiecesOptions& options) {
  check(options);
  check(mesh);
  const auto whole = solid_hull(mesh.vertices, options.max_hull_vertices);
  if (!whole) throw InputError("the mesh has no volume", "give a closed mesh");
  const double diagonal = geometry::bounds(mesh).diagonal().norm();
  if (options.min_pieces == 1 && hull_concavity(mesh, *whole) <= options.concavity * diagonal) {
    return {*whole};
  }
  const TriangleMesh coarse = thinned(mesh, options.max_triangles);
  if (coarse.empty()) return {*whole};
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
  if (pieces.empty()) pieces.push_back(*whole);
  return pieces;
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
