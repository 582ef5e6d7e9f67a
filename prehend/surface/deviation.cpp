#include "prehend/surface/deviation.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "prehend/geometry/errors.h"

namespace prehend::surface {
namespace {

/// Uniform in [0, 1), the same on every standard library.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

}  // namespace

std::vector<Eigen::Vector3d> sample_surface(const geometry::TriangleMesh& mesh, int samples,
                                            std::uint64_t seed) {
  if (samples < 1) throw std::invalid_argument("sample_surface: samples must be >= 1");
  std::vector<double> cumulated_area;
  double area = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t.x()];
    area += 0.5 * (mesh.vertices[t.y()] - a).cross(mesh.vertices[t.z()] - a).norm();
    cumulated_area.push_back(area);
  }
  if (!(area > 0) || !std::isfinite(area)) {
    throw geometry::InputError("the mesh has no area", "give a mesh with triangles");
  }
  std::mt19937_64 random(seed);
  std::vector<Eigen::Vector3d> points;
  points.reserve(samples);
  for (int i = 0; i < samples; ++i) {
    // Stratified over the area: one point in each of `samples` equal parts.
    const double at = (i + uniform(random)) / samples * area;
    const auto found = std::lower_bound(cumulated_area.begin(), cumulated_area.end(), at);
    const auto triangle =
        std::min<std::size_t>(found - cumulated_area.begin(), mesh.triangles.size() - 1);
    const Eigen::Vector3i& t = mesh.triangles[triangle];
    const double root = std::sqrt(uniform(random));
    const double second = uniform(random);
    points.push_back((1 - root) * mesh.vertices[t.x()] +
                     root * (1 - second) * mesh.vertices[t.y()] +
                     root * second * mesh.vertices[t.z()]);
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
  const auto first_points = sample_surface(first, options.samples, options.seed);
  const auto second_points = sample_surface(second, options.samples, options.seed);
  return {deviation(first_points, geometry::MeshQuery(second)),
          deviation(second_points, geometry::MeshQuery(first))};
}

}  // namespace prehend::surface
