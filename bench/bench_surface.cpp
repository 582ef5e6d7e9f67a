// Surfaces of clouds: time, and mean deviation from the solid that the points were taken from. The
// references run once each in the same process, so that the ratios are of one machine at one time.

#include <ctime>
#include <map>
#include <numbers>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>

#include "prehend/shape/symmetry.h"
#include "prehend/surface/convex_pieces.h"
#include "prehend/surface/delaunay.h"
#include "prehend/surface/model.h"
#include "tests/oracles/reference_pieces.h"
#include "tests/shape/synthetic_view.h"
#include "tests/surface/sampled_solid.h"

namespace {

using namespace prehend;
using geometry::TriangleMesh;

constexpr int kPoints = 40000;

enum Solid : int { kCylinder, kBox };

/// Turned, so that no face lies along a grid.
const TriangleMesh& solid(int which) {
  static const auto make = [](const TriangleMesh& mesh) {
    geometry::RigidTransform X = geometry::RigidTransform::Identity();
    X.linear() = Eigen::AngleAxisd(0.5, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
    return geometry::transformed(mesh, X);
  };
  static const TriangleMesh cylinder =
      make(geometry::make_revolution({{0.04, 0}, {0.04, 0.1}}, 256));
  static const TriangleMesh box = make(geometry::make_box({0.06, 0.08, 0.1}));
  return which == kCylinder ? cylinder : box;
}

const geometry::PointCloud& cloud(int which) {
  static const geometry::PointCloud clouds[] = {surface::sampled(solid(kCylinder), kPoints),
                                                surface::sampled(solid(kBox), kPoints)};
  return clouds[which];
}

/// Processor time, as that of the rates below.
template <typename Function>
double seconds_of(Function f) {
  const std::clock_t start = std::clock();
  benchmark::DoNotOptimize(f());
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
}

/// Of one run on the same points.
double pcl_seconds(int which, int depth) {
  static std::map<std::pair<int, int>, double> known;
  double& seconds = known[{which, depth}];
  if (seconds == 0) {
    seconds = seconds_of([&] { return surface::pcl_poisson(cloud(which), {.depth = depth}); });
  }
  return seconds;
}

void report_errors(benchmark::State& state, const TriangleMesh& mesh, const TriangleMesh& truth) {
  const surface::MeshDeviation d = surface::mesh_deviation(mesh, truth);
  state.counters["to_truth_mm"] = d.to_second.mean * 1e3;
  state.counters["from_truth_mm"] = d.from_second.mean * 1e3;
  state.counters["from_truth_max_mm"] = d.from_second.max * 1e3;
  state.counters["triangles"] = static_cast<double>(mesh.triangles.size());
  state.counters["defects"] = geometry::find_defects(mesh).watertight() ? 0 : 1;
}

/// How often the benchmark's iterations fit into `seconds`.
benchmark::Counter ratio(double seconds) {
  return {seconds, benchmark::Counter::kIsIterationInvariantRate};
}

void BM_FastPoisson(benchmark::State& state) {
  const int which = static_cast<int>(state.range(0));
  const surface::FastPoissonOptions options{.resolution = static_cast<int>(state.range(1))};
  TriangleMesh mesh;
  for (auto _ : state) mesh = surface::fast_poisson(cloud(which), std::nullopt, options).mesh;
  report_errors(state, mesh, solid(which));
  state.counters["times_faster_than_pcl_6"] = ratio(pcl_seconds(which, 6));
  state.counters["times_faster_than_pcl_7"] = ratio(pcl_seconds(which, 7));
}
BENCHMARK(BM_FastPoisson)
    ->ArgNames({"box", "resolution"})
    ->ArgsProduct({{kCylinder, kBox}, {64, 96, 128}})
    ->Unit(benchmark::kMillisecond);

void BM_PclPoisson(benchmark::State& state) {
  const int which = static_cast<int>(state.range(0));
  TriangleMesh mesh;
  for (auto _ : state) {
    mesh = surface::pcl_poisson(cloud(which), {.depth = static_cast<int>(state.range(1))});
  }
  report_errors(state, mesh, solid(which));
}
BENCHMARK(BM_PclPoisson)
    ->ArgNames({"box", "depth"})
    ->ArgsProduct({{kCylinder, kBox}, {5, 6, 7}})
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

/// A view of a standing solid, completed by symmetry.
struct Completed {
  TriangleMesh truth;
  shape::SyntheticView view;
  shape::CompletedShape shape;
};

const Completed& completed(int which) {
  static const auto make = [](const TriangleMesh& mesh) {
    Completed result;
    result.truth = shape::standing(mesh, 0.5);
    result.view = shape::synthetic_view(result.truth, {.distance = 0.45, .depth_noise = 0.0005});
    result.shape = shape::complete_by_symmetry(result.view.view());
    return result;
  };
  static const Completed all[] = {make(geometry::make_revolution({{0.04, 0}, {0.04, 0.1}}, 256)),
                                  make(geometry::make_box({0.06, 0.08, 0.1}))};
  return all[which];
}

void BM_MirroredView(benchmark::State& state) {
  const Completed& object = completed(static_cast<int>(state.range(0)));
  surface::SurfaceOptions options;
  if (state.range(1) <= 10) {
    options.method = surface::SurfaceMethod::kPclPoisson;
    options.pcl_poisson.depth = static_cast<int>(state.range(1));
  } else {
    options.fast_poisson.resolution = static_cast<int>(state.range(1));
  }
  const geometry::PointCloud points = surface::oriented_cloud(object.shape);
  TriangleMesh mesh;
  for (auto _ : state) mesh = surface::reconstruct(points, object.view.table_W, options);
  report_errors(state, mesh, object.truth);
  state.counters["points"] = static_cast<double>(points.size());
}
BENCHMARK(BM_MirroredView)
    ->ArgNames({"box", "depth_or_resolution"})
    ->ArgsProduct({{kCylinder, kBox}, {6, 7, 64, 128}})
    ->Unit(benchmark::kMillisecond);

void BM_OrientedCloud(benchmark::State& state) {
  const Completed& object = completed(static_cast<int>(state.range(0)));
  for (auto _ : state) benchmark::DoNotOptimize(surface::oriented_cloud(object.shape));
  state.counters["points"] = static_cast<double>(object.shape.cloud_W.size());
}
BENCHMARK(BM_OrientedCloud)
    ->ArgName("box")
    ->Arg(kCylinder)
    ->Arg(kBox)
    ->Unit(benchmark::kMillisecond);

/// From a completed shape to a watertight mesh, without convex pieces and mass properties.
void BM_CloudToMesh(benchmark::State& state) {
  const Completed& object = completed(static_cast<int>(state.range(0)));
  for (auto _ : state) {
    const geometry::PointCloud points = surface::oriented_cloud(object.shape);
    benchmark::DoNotOptimize(surface::reconstruct(points, object.view.table_W));
  }
  state.counters["points"] = static_cast<double>(object.shape.cloud_W.size());
}
BENCHMARK(BM_CloudToMesh)->ArgName("box")->Arg(kCylinder)->Arg(kBox)->Unit(benchmark::kMillisecond);

/// A view of 40 000 points.
const shape::SyntheticView& segmented(int which) {
  static const auto make = [](const TriangleMesh& mesh) {
    shape::SyntheticView view =
        shape::synthetic_view(shape::standing(mesh, 0.5), {.distance = 0.4, .depth_noise = 0.0005});
    const std::vector<Eigen::Vector3f> all = std::move(view.cloud_W.points);
    view.cloud_W.points.clear();
    for (std::size_t i = 0; i < kPoints; ++i) {
      view.cloud_W.points.push_back(all.at(i * all.size() / kPoints));
    }
    return view;
  };
  static const shape::SyntheticView views[] = {
      make(geometry::make_revolution({{0.04, 0}, {0.04, 0.1}}, 256)),
      make(geometry::make_box({0.06, 0.08, 0.1}))};
  return views[which];
}

enum Way : int { kDefault, kThinned, kPclDepth7, kUnsmoothed };

/// From a segmented cloud to a watertight mesh; the unsmoothed one is the default but for that.
void BM_WholeChain(benchmark::State& state) {
  const int which = static_cast<int>(state.range(0));
  const shape::SyntheticView& view = segmented(which);
  surface::ModelOptions options;
  if (state.range(1) == kThinned) {
    options.cloud.spacing = 0.003;
    options.surface.fast_poisson.resolution = 80;
  } else if (state.range(1) == kPclDepth7) {
    options.surface.method = surface::SurfaceMethod::kPclPoisson;
    options.surface.pcl_poisson.depth = 7;
  } else if (state.range(1) == kUnsmoothed) {
    options.cloud.smooth = false;
  }
  TriangleMesh mesh;
  double completion = 0;
  for (auto _ : state) {
    shape::CompletedShape completed;
    completion += seconds_of([&] {
      completed = shape::complete_by_symmetry(view.view());
      return completed.cloud_W.size();
    });
    mesh = surface::mesh_of(completed, view.table_W, options);
  }
  state.counters["completion_ms"] = 1e3 * completion / static_cast<double>(state.iterations());
  report_errors(state, mesh, completed(which).truth);
  state.counters["normal_error_deg"] =
      surface::median_normal_error(mesh, completed(which).truth) * 180 / std::numbers::pi;
}
BENCHMARK(BM_WholeChain)
    ->ArgNames({"box", "way"})
    ->ArgsProduct({{kCylinder, kBox}, {kDefault, kThinned, kPclDepth7, kUnsmoothed}})
    ->Unit(benchmark::kMillisecond);

void BM_ObjectModel(benchmark::State& state) {
  const Completed& object = completed(static_cast<int>(state.range(0)));
  surface::ModelTimes times;
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        surface::make_object_model(object.shape, object.view.table_W, {}, &times));
  }
  state.counters["normals_ms"] = times.normals * 1e3;
  state.counters["surface_ms"] = times.poisson * 1e3;
  state.counters["convex_pieces_ms"] = times.convex_pieces * 1e3;
  state.counters["properties_ms"] = times.properties * 1e3;
}
BENCHMARK(BM_ObjectModel)->ArgName("box")->Arg(kCylinder)->Arg(kBox)->Unit(benchmark::kMillisecond);

void BM_Delaunay(benchmark::State& state) {
  const Completed& object = completed(static_cast<int>(state.range(0)));
  TriangleMesh mesh;
  for (auto _ : state) {
    mesh = surface::delaunay_surface(object.view.cloud_W, object.view.camera, object.view.X_WC);
  }
  report_errors(state, mesh, object.truth);
}
BENCHMARK(BM_Delaunay)->ArgName("box")->Arg(kCylinder)->Arg(kBox)->Unit(benchmark::kMillisecond);

/// 10 000 triangles.
const TriangleMesh& torus() {
  static const TriangleMesh mesh = surface::make_torus(0.04, 0.015, 100, 50);
  return mesh;
}

void BM_ConvexPieces(benchmark::State& state) {
  surface::ConvexPieces result;
  const double concavity = static_cast<double>(state.range(0)) * 1e-3;
  for (auto _ : state) result = surface::convex_pieces(torus(), {.concavity = concavity});
  static const double hacd = seconds_of([] { return surface::hacd_pieces(torus()); });
  state.counters["pieces"] = static_cast<double>(result.pieces.size());
  state.counters["concavity_mm"] = result.concavity * 1e3;
  state.counters["times_faster_than_hacd_thinned_to_700"] = ratio(hacd);
}
BENCHMARK(BM_ConvexPieces)
    ->ArgName("concavity_mm")
    ->Arg(10)
    ->Arg(4)
    ->Arg(2)
    ->Unit(benchmark::kMillisecond);

/// HACD on the whole mesh takes seconds; `triangles` is what the mesh is thinned to.
void BM_Hacd(benchmark::State& state) {
  std::size_t pieces = 0;
  for (auto _ : state) {
    pieces =
        surface::hacd_pieces(torus(), {.max_triangles = static_cast<int>(state.range(0))}).size();
  }
  state.counters["pieces"] = static_cast<double>(pieces);
}
BENCHMARK(BM_Hacd)
    ->ArgName("triangles")
    ->Arg(700)
    ->Arg(10000)
    ->Iterations(1)
    ->Unit(benchmark::kMillisecond);

void BM_ConvexDecomposition(benchmark::State& state) {
  std::size_t pieces = 0;
  for (auto _ : state) pieces = surface::ratcliff_pieces(torus()).size();
  state.counters["pieces"] = static_cast<double>(pieces);
}
BENCHMARK(BM_ConvexDecomposition)->Iterations(1)->Unit(benchmark::kMillisecond);

}  // namespace
