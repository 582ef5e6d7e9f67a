#pragma once

#include <cstdint>
#include <vector>

#include <Eigen/Core>

#include "prehend/geometry/mesh_query.h"
#include "prehend/geometry/triangle_mesh.h"

namespace prehend::surface {

/// Distances of points to a surface [m].
struct DeviationStatistics {
  double mean = 0;
  double variance = 0;  // about the mean, of the sample [m^2]
  double percentile_95 = 0;
  double max = 0;
};

struct MeshDeviation {
  DeviationStatistics to_second;    // from points of the first mesh to the second
  DeviationStatistics from_second;  // from points of the second mesh to the first
};

struct DeviationOptions {
  int samples = 20000;  // points on each mesh, >= 1
  std::uint64_t seed = 1;
};

/// `samples` points [m] distributed uniformly over the area of `mesh`; the same seed gives the same
/// points. @throws geometry::InputError for a mesh without area.
std::vector<Eigen::Vector3d> sample_surface(const geometry::TriangleMesh& mesh, int samples,
                                            std::uint64_t seed);

/// Unsigned distances of `points` to the surface. @throws geometry::InputError without points.
DeviationStatistics deviation(const std::vector<Eigen::Vector3d>& points,
                              const geometry::MeshQuery& surface);

/// Both directed deviations, as MeshDev measures them (Roy, Foufou, Truchetet: "Mesh comparison
/// using attribute deviation metric", International Journal of Image and Graphics 2004): points
/// spread uniformly over one mesh, and the distance of each to the other mesh. @throws
/// geometry::InputError for a mesh without area.
MeshDeviation mesh_deviation(const geometry::TriangleMesh& first,
                             const geometry::TriangleMesh& second,
                             const DeviationOptions& options = {});

/// Median angle [rad] between outward normals of `mesh` at points spread uniformly over it and
/// those of `truth` where it is nearest to them. @throws geometry::InputError for a mesh without
/// area.
double median_normal_error(const geometry::TriangleMesh& mesh, const geometry::TriangleMesh& truth,
                           const DeviationOptions& options = {});

}  // namespace prehend::surface
