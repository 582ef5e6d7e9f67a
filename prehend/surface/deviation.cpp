#include "prehend/surface/deviation.h"

#include <algorithm>
#include <cmath>

#include "prehend/geometry/errors.h"
#include "prehend/geometry/surface_samples.h"

namespace prehend::surface {
namespace {

Eigen::Vector3d normal_of(const geometry::TriangleMesh& mesh, int triangle) {
  const Eigen::Vector3i& t = mesh.triangles[triangle];
  const Eigen::Vector3d& a = mesh.vertices[t.x()];
  return (mesh.vertices[t.y()] - a).cross(mesh.vertices[t.z()] - a).normalized();
}

}  // namespace

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

double median_normal_error(const geometry::TriangleMesh& mesh, const geometry::TriangleMesh& truth,
                           const DeviationOptions& options) {
  const geometry::MeshQuery on_truth(truth);
  std::vector<double> angles;
  for (const auto& sample : geometry::surface_samples(mesh, options.samples, options.seed)) {
    const auto nearest = on_truth.nearest(sample.point);
    if (!nearest) {
      throw geometry::InputError("a mesh has a vertex that is not finite", "mend the mesh");
    }
    const double cosine = normal_of(mesh, sample.triangle).dot(normal_of(truth, nearest->triangle));
    angles.push_back(std::acos(std::clamp(cosine, -1.0, 1.0)));
  }
  const auto middle = angles.begin() + static_cast<std::ptrdiff_t>(angles.size() / 2);
  std::nth_element(angles.begin(), middle, angles.end());
  return *middle;
}

}  // namespace prehend::surface
