#include "prehend/geometry/surface_samples.h"

#include <algorithm>
#include <cmath>
#include <random>
#include <stdexcept>

#include "prehend/geometry/errors.h"

namespace prehend::geometry {
namespace {

/// Uniform in [0, 1), the same on every standard library.
double uniform(std::mt19937_64& random) { return static_cast<double>(random() >> 11) * 0x1.0p-53; }

}  // namespace

std::vector<SurfaceSample> surface_samples(const TriangleMesh& mesh, int samples,
                                           std::uint64_t seed) {
  if (samples < 1) throw std::invalid_argument("surface_samples: samples must be >= 1");
  std::vector<double> cumulated_area;
  double area = 0;
  for (const Eigen::Vector3i& t : mesh.triangles) {
    const Eigen::Vector3d& a = mesh.vertices[t.x()];
    area += 0.5 * (mesh.vertices[t.y()] - a).cross(mesh.vertices[t.z()] - a).norm();
    cumulated_area.push_back(area);
  }
  if (!(area > 0) || !std::isfinite(area)) {
    throw InputError("the mesh has no area", "give a mesh with triangles");
  }
  std::mt19937_64 random(seed);
  std::vector<SurfaceSample> points;
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
    points.push_back({(1 - root) * mesh.vertices[t.x()] +
                          root * (1 - second) * mesh.vertices[t.y()] +
                          root * second * mesh.vertices[t.z()],
                      static_cast<int>(triangle)});
  }
  return points;
}

}  // namespace prehend::geometry
