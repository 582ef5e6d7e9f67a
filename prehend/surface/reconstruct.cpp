#include "prehend/surface/reconstruct.h"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <Eigen/Geometry>

#include "prehend/geometry/errors.h"
#include "prehend/surface/closing.h"
#include "prehend/surface/mesh_parts.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using geometry::TriangleMesh;

constexpr std::size_t kLeastPoints = 30;
constexpr double kLeastShare = 0.05;

/// Longest side of the cloud's bounds [m].
double extent(const geometry::PointCloud& cloud) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : cloud.points) box.extend(p.cast<double>());
  return box.sizes().maxCoeff();
}

void check_input(const geometry::PointCloud& cloud) {
  if (cloud.normals.size() != cloud.size()) {
    throw InputError("the cloud has no normals", "estimate normals first");
  }
  if (cloud.size() < kLeastPoints) {
    throw InputError(
        "the cloud has " + std::to_string(cloud.size()) + " points, too few for a mesh",
        "give at least " + std::to_string(kLeastPoints));
  }
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    if (!geometry::is_finite(cloud.points[i]) || !geometry::is_finite(cloud.normals[i])) {
      throw InputError("the cloud has points or normals that are not finite",
                       "remove invalid points");
    }
  }
  if (!(extent(cloud) > 0)) {
    throw InputError("all points of the cloud coincide", "segment the object again");
  }
}

using Bounds = std::span<const geometry::Plane>;

/// What lies under the table or one of the bounds comes to lie on it.
void put_on(TriangleMesh& mesh, const std::optional<geometry::Plane>& table, Bounds bounds) {
  constexpr int kMostPasses = 100;  // where planes meet, one projection undoes some of another
  std::vector<geometry::Plane> planes(bounds.begin(), bounds.end());
  if (table) planes.push_back(*table);
  for (Eigen::Vector3d& vertex : mesh.vertices) {
    bool is_moved = true;
    for (int pass = 0; is_moved && pass < kMostPasses; ++pass) {
      is_moved = false;
      for (const geometry::Plane& plane : planes) {
        if (plane.signed_distance(vertex) >= 0) continue;
        vertex = plane.project(vertex);
        is_moved = planes.size() > 1;
      }
    }
  }
}

/// Points on the octree's cell borders can leave holes; another cube moves the borders.
TriangleMesh by_pcl(const geometry::PointCloud& cloud, const std::optional<geometry::Plane>& table,
                    Bounds bounds, const PclPoissonOptions& options) {
  std::string problem;
  for (const double larger_scale : {1.0, 1.07, 1.03, 1.11}) {
    PclPoissonOptions attempt = options;
    attempt.scale = options.scale * larger_scale;
    TriangleMesh mesh = pcl_poisson(cloud, attempt);
    put_on(mesh, table, bounds);
    const geometry::MeshDefects defects = geometry::find_defects(mesh);
    if (!mesh.empty() && defects.watertight()) {
      if (geometry::mass_properties(mesh).volume < 0) {
        for (Eigen::Vector3i& t : mesh.triangles) std::swap(t.y(), t.z());
      }
      return mesh;
    }
    problem = mesh.empty() ? "no triangles" : defects.to_string();
  }
  throw InputError("no watertight mesh came out of " + std::to_string(cloud.size()) +
                       " points at depth " + std::to_string(options.depth) + " (" + problem + ")",
                   "give more or cleaner points, another Poisson depth, or use fast_poisson");
}

TriangleMesh by_fast_poisson(const geometry::PointCloud& cloud,
                             const std::optional<geometry::Plane>& table, Bounds bounds,
                             const FastPoissonOptions& options, const EmptySpace& empty) {
  PoissonSurface surface = fast_poisson(cloud, table, options, empty, bounds);
  if (surface.inside_out) {
    throw InputError("no watertight mesh came out of " + std::to_string(cloud.size()) +
                         " points: their normals point inward",
                     "turn the normals round");
  }
  if (surface.is_open) {
    throw InputError("no watertight mesh came out of " + std::to_string(cloud.size()) +
                         " points: their surface is open, what is behind it has no end",
                     "give points of the other side, or normals that point outward");
  }
  put_on(surface.mesh, table, bounds);
  return std::move(surface.mesh);
}

}  // namespace

TriangleMesh reconstruct(const geometry::PointCloud& cloud,
                         const std::optional<geometry::Plane>& table, const SurfaceOptions& options,
                         const EmptySpace& empty, std::span<const geometry::Plane> bounds) {
  if (!(options.footprint_slice > 0 && options.footprint_slice <= 1)) {
    throw std::invalid_argument("SurfaceOptions.footprint_slice must be in (0, 1]");
  }
  check_input(cloud);
  const double spacing = extent(cloud) / 90;
  const geometry::PointCloud closed =
      table && options.close_bottom ? close_bottom(cloud, *table, options.footprint_slice, spacing)
                                    : cloud;
  const TriangleMesh mesh =
      solid_parts(options.method == SurfaceMethod::kPclPoisson
                      ? by_pcl(closed, table, bounds, options.pcl_poisson)
                      : by_fast_poisson(closed, table, bounds, options.fast_poisson, empty),
                  kLeastShare);
  if (mesh.empty()) {
    throw InputError("no watertight mesh came out of " + std::to_string(cloud.size()) +
                         " points: their normals enclose nothing",
                     "give normals that point outward");
  }
  return mesh;
}

}  // namespace prehend::surface
