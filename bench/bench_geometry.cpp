// Ray and nearest-point queries against the brute force over all triangles.

#include <random>

#include <benchmark/benchmark.h>

#include "prehend/geometry/mesh_query.h"

namespace {

using namespace prehend::geometry;

std::vector<Eigen::Vector3d> points_around(double radius, int count) {
  std::mt19937 random(1);
  std::normal_distribution<double> normal;
  std::vector<Eigen::Vector3d> points;
  for (int i = 0; i < count; ++i) {
    points.push_back(radius *
                     Eigen::Vector3d(normal(random), normal(random), normal(random)).normalized());
  }
  return points;
}

void BM_CastRay(benchmark::State& state) {
  const MeshQuery query(make_sphere(0.05, static_cast<int>(state.range(0))));
  const auto origins = points_around(0.2, 1024);
  std::size_t i = 0;
  for (auto _ : state) {
    const auto& origin = origins[i++ % origins.size()];
    benchmark::DoNotOptimize(query.cast_ray(origin, -origin.normalized()));
  }
  state.counters["triangles"] = static_cast<double>(query.mesh().triangles.size());
}
BENCHMARK(BM_CastRay)->Arg(32)->Arg(320);

void BM_NearestPoint(benchmark::State& state) {
  const MeshQuery query(make_sphere(0.05, static_cast<int>(state.range(0))));
  const auto points = points_around(0.06, 1024);
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(query.nearest(points[i++ % points.size()]));
  state.counters["triangles"] = static_cast<double>(query.mesh().triangles.size());
}
BENCHMARK(BM_NearestPoint)->Arg(32)->Arg(320);

// The baseline: every triangle's plane is met.
void BM_CastRayBruteForce(benchmark::State& state) {
  const TriangleMesh mesh = make_sphere(0.05, static_cast<int>(state.range(0)));
  const auto origins = points_around(0.2, 1024);
  std::size_t i = 0;
  for (auto _ : state) {
    const Eigen::Vector3d origin = origins[i++ % origins.size()];
    const Eigen::Vector3d direction = -origin.normalized();
    double nearest = 1e9;
    for (const auto& t : mesh.triangles) {
      // Moeller and Trumbore, "Fast, Minimum Storage Ray/Triangle Intersection", 1997.
      const Eigen::Vector3d e1 = mesh.vertices[t[1]] - mesh.vertices[t[0]];
      const Eigen::Vector3d e2 = mesh.vertices[t[2]] - mesh.vertices[t[0]];
      const Eigen::Vector3d p = direction.cross(e2);
      const double determinant = e1.dot(p);
      if (std::abs(determinant) < 1e-15) continue;
      const Eigen::Vector3d s = origin - mesh.vertices[t[0]];
      const double u = s.dot(p) / determinant;
      const Eigen::Vector3d q = s.cross(e1);
      const double v = direction.dot(q) / determinant;
      const double distance = e2.dot(q) / determinant;
      if (u >= 0 && v >= 0 && u + v <= 1 && distance > 0) nearest = std::min(nearest, distance);
    }
    benchmark::DoNotOptimize(nearest);
  }
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
}
BENCHMARK(BM_CastRayBruteForce)->Arg(32)->Arg(320);

}  // namespace
