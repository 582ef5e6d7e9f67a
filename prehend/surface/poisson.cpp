#include "prehend/surface/poisson.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>
#include <vector>

#include <pcl/point_types.h>
#include <pcl/surface/poisson.h>

#include "prehend/geometry/errors.h"
#include "prehend/surface/closing.h"
#include "prehend/surface/holes.h"

namespace prehend::surface {
namespace {

using geometry::InputError;
using geometry::TriangleMesh;

constexpr std::size_t kLeastPoints = 30;
constexpr double kLeastShare = 0.05;
// Of the surface that may be made of closed holes. More is not a hole but an open surface.
constexpr double kLargestClosedShare = 0.05;

void check(const PoissonOptions& options) {
  const auto require = [](bool condition, const std::string& what) {
    if (!condition) throw std::invalid_argument("PoissonOptions." + what);
  };
  require(options.depth >= 3 && options.depth <= 10, "depth must be in [3, 10]");
  require(options.samples_per_node >= 1 && options.samples_per_node <= 20,
          "samples_per_node must be in [1, 20]");
  require(options.point_weight >= 0 && std::isfinite(options.point_weight),
          "point_weight must be >= 0");
  require(options.scale >= 1.05 && options.scale <= 3, "scale must be in [1.05, 3]");
  require(options.footprint_slice > 0 && options.footprint_slice <= 1,
          "footprint_slice must be in (0, 1]");
}

/// Cloud brought to unit size about the origin, so that PCL's single precision does not matter.
struct Normalization {
  Eigen::Vector3d center = Eigen::Vector3d::Zero();
  double size = 1;
};

Normalization normalization_of(const geometry::PointCloud& cloud) {
  Eigen::AlignedBox3d box;
  for (const Eigen::Vector3f& p : cloud.points) box.extend(p.cast<double>());
  return {box.center(), box.sizes().maxCoeff()};
}

TriangleMesh poisson_mesh(const geometry::PointCloud& cloud, const PoissonOptions& options) {
  const Normalization normalization = normalization_of(cloud);
  auto input = std::make_shared<pcl::PointCloud<pcl::PointNormal>>();
  input->reserve(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    pcl::PointNormal point;
    point.getVector3fMap() =
        ((cloud.points[i].cast<double>() - normalization.center) / normalization.size)
            .cast<float>();
    point.getNormalVector3fMap() = cloud.normals[i];
    input->push_back(point);
  }
  pcl::Poisson<pcl::PointNormal> poisson;
  poisson.setInputCloud(input);
  poisson.setDepth(options.depth);
  poisson.setMinDepth(std::min(options.depth, 5));
  // Blocks smaller than the tree would leave seams.
  poisson.setSolverDivide(options.depth);
  poisson.setIsoDivide(options.depth);
  poisson.setSamplesPerNode(static_cast<float>(options.samples_per_node));
  poisson.setPointWeight(static_cast<float>(options.point_weight));
  poisson.setScale(static_cast<float>(options.scale));
  poisson.setManifold(true);
  poisson.setOutputPolygons(false);
  poisson.setThreads(1);
  pcl::PointCloud<pcl::PointNormal> vertices;
  std::vector<pcl::Vertices> polygons;
  poisson.performReconstruction(vertices, polygons);

  TriangleMesh mesh;
  for (const auto& vertex : vertices) {
    mesh.vertices.push_back(normalization.center +
                            normalization.size * vertex.getVector3fMap().cast<double>());
  }
  for (const pcl::Vertices& polygon : polygons) {
    if (polygon.vertices.size() != 3) continue;
    mesh.triangles.emplace_back(polygon.vertices[0], polygon.vertices[1], polygon.vertices[2]);
  }
  return mesh;
}

/// The connected parts with at least `kLeastShare` of the triangles of the largest one.
TriangleMesh without_crumbs(const TriangleMesh& mesh) {
  std::vector<int> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const Eigen::Vector3i& t : mesh.triangles) {
    parent[root(t.y())] = root(t.x());
    parent[root(t.z())] = root(t.x());
  }
  std::vector<int> triangles(mesh.vertices.size(), 0);
  for (const Eigen::Vector3i& t : mesh.triangles) ++triangles[root(t.x())];
  const int largest = triangles.empty() ? 0 : *std::max_element(triangles.begin(), triangles.end());

  TriangleMesh part;
  std::vector<int> renumbered(mesh.vertices.size(), -1);
  for (const Eigen::Vector3i& t : mesh.triangles) {
    if (triangles[root(t.x())] < kLeastShare * largest) continue;
    Eigen::Vector3i triangle;
    for (int corner = 0; corner < 3; ++corner) {
      int& index = renumbered[t(corner)];
      if (index < 0) {
        index = static_cast<int>(part.vertices.size());
        part.vertices.push_back(mesh.vertices[t(corner)]);
      }
      triangle(corner) = index;
    }
    part.triangles.push_back(triangle);
  }
  return part;
}

void turn_outward(TriangleMesh& mesh) {
  if (geometry::mass_properties(mesh).volume >= 0) return;
  for (Eigen::Vector3i& t : mesh.triangles) std::swap(t.y(), t.z());
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
  if (!(normalization_of(cloud).size > 0)) {
    throw InputError("all points of the cloud coincide", "segment the object again");
  }
}

}  // namespace

TriangleMesh reconstruct(const geometry::PointCloud& cloud,
                         const std::optional<geometry::Plane>& table,
                         const PoissonOptions& options) {
  check(options);
  check_input(cloud);
  const double spacing = normalization_of(cloud).size / 90;
  const geometry::PointCloud closed =
      table && options.close_bottom ? close_bottom(cloud, *table, options.footprint_slice, spacing)
                                    : cloud;
  // Points on the octree's cell borders can leave holes; another cube moves the borders.
  struct Attempt {
    int less_depth;
    double larger_scale;
  };
  std::string problem;
  std::optional<TriangleMesh> best_closed;  // of the attempts with holes
  double least_closed_area = kLargestClosedShare;
  for (const auto& [less_depth, larger_scale] :
       {Attempt{0, 1}, Attempt{0, 1.07}, Attempt{1, 1.03}, Attempt{2, 1.11}}) {
    PoissonOptions attempt = options;
    attempt.depth = std::max(3, options.depth - less_depth);
    attempt.scale = options.scale * larger_scale;
    TriangleMesh mesh = without_crumbs(poisson_mesh(closed, attempt));
    if (table) {
      for (Eigen::Vector3d& vertex : mesh.vertices) {
        if (table->signed_distance(vertex) < 0) vertex = table->project(vertex);
      }
    }
    const geometry::MeshDefects defects = geometry::find_defects(mesh);
    if (!mesh.empty() && defects.watertight()) {
      turn_outward(mesh);
      return mesh;
    }
    const ClosedHoles closing = close_holes(mesh);
    const double share = closing.area / std::max(geometry::surface_area(mesh), 1e-30);
    if (share < least_closed_area && geometry::find_defects(mesh).watertight()) {
      least_closed_area = share;
      best_closed = mesh;
    }
    problem += (problem.empty() ? "" : "; ") + std::string("depth ") +
               std::to_string(attempt.depth) + ": " +
               (mesh.empty() ? "no triangles" : defects.to_string());
  }
  if (best_closed) {
    turn_outward(*best_closed);
    return *best_closed;
  }
  throw InputError("no watertight mesh came out of " + std::to_string(cloud.size()) + " points (" +
                       problem + ")",
                   "give more or cleaner points, or another Poisson depth");
}

}  // namespace prehend::surface
