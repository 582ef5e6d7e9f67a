#include "prehend/surface/deviation.h"

#include <algorithm>
#include <cmath>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/surface_samples.h"

namespace prehend::surface {

std::vector<Eigen::Vector3d> sample_surface(const geometry::TriangleMesh& mesh, int samples,
                                            std::uint64_t seed) {
  std::vector<Eigen::Vector3d> points;
  for (const auto& sample : geometry::surface_samples(mesh, samples, seed)) {
    points.push_back(sample.point);
  }
  return points;
}

DeviationStatistics deviation(const std::vector<Eigen::Vector3d>& points,
                              const geometry::MeshQuery& surface) {
  if (points.empty()) {
    throw geometry::InputError("no points to measure a deviation of", "give at least one point");
  }
  std::vector<double> distances;
  distances.reserve(points.size());
  double sum = 0;
  for (const Eigen::Vector3d& p : points) {
    const auto nearest = surface.nearest(p);
    if (!nearest) {
      throw geometry::InputError("a point has no nearest point on the mesh",
                                 "remove points that are not finite");
    }
    distances.push_back(nearest->distance);
    sum += nearest->distance;
  }
  DeviationStatistics result;
  result.mean = sum / static_cast<double>(distances.size());
  for (const double distance : distances) {
    result.variance += (distance - result.mean) * (distance - result.mean);
  }
  result.variance /= static_cast<double>(distances.size());
  std::sort(distances.begin(), distances.end());
  result.percentile_95 = distances[(distances.size() - 1) * 95 / 100];
  result.max = distances.back();
  return result;
}

MeshDeviation mesh_deviation(const geometry::TriangleMesh& first,
                             const geometry::TriangleMesh& second,
                             const DeviationOptions& options) {
  const auto first_points = surface::sample_surface(first, options.samples, options.seed);
  const auto second_points = surface::sample_surface(second, options.samples, options.seed);
  return {deviation(first_points, geometry::MeshQuery(second)),
          deviation(second_points, geometry::MeshQuery(first))};
}

}  // namespace prehend::surface
