// Each stage of the chain on the demo's scene, from rendered images to the simulated grasp.

#include <benchmark/benchmark.h>

#include "prehend/grasp/planner.h"
#include "prehend/perception/binning.h"
#include "prehend/perception/segmentation.h"
#include "prehend/perception/stereo.h"
#include "prehend/shape/object_view.h"
#include "prehend/shape/symmetry.h"
#include "prehend/simulation/scene.h"
#include "prehend/simulation/stereo_renderer.h"
#include "prehend/simulation/world.h"
#include "prehend/surface/model.h"

namespace {

using namespace prehend;

// Everything up to the grasp, made once. Run from the project's folder.
struct Chain {
  simulation::Scene scene = simulation::read_scene("config/scenes/demo.yaml");
  simulation::World world{scene};
  simulation::StereoImages images = simulation::render_stereo(scene, world.visible_bodies());
  perception::DisparityImage disparity =
      perception::disparity_by_sgbm(images.left, images.right, scene.camera.camera);
  geometry::PointCloud cloud_C =
      perception::cloud_from_disparity(disparity, scene.camera.camera, images.left);
  perception::SegmentedScene segmented =
      perception::segment(cloud_C, scene.camera.camera.left, scene.camera.X_WC());
  std::size_t target = nearest_to_origin();
  shape::CompletedShape shape = complete();
  surface::ObjectModel model = surface::make_object_model(shape, segmented.table_W);

  std::size_t nearest_to_origin() const {
    std::size_t best = 0;
    for (std::size_t i = 0; i < segmented.objects.size(); ++i) {
      if (geometry::centroid(segmented.objects[i].cloud_W).head<2>().norm() <
          geometry::centroid(segmented.objects[best].cloud_W).head<2>().norm()) {
        best = i;
      }
    }
    return best;
  }
  shape::CompletedShape complete() const {
    const auto& object = segmented.objects.at(target);
    return shape::complete_by_symmetry(shape::view_of(segmented, object));
  }
  grasp::GraspPlan plan() const {
    return grasp::plan_grasps(model, segmented.table_W, {}, scene.gripper, {});
  }
};

const Chain& chain() {
  static const Chain instance;
  return instance;
}

void BM_RenderStereo(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(
        simulation::render_stereo(chain().scene, chain().world.visible_bodies()));
  }
}
BENCHMARK(BM_RenderStereo)->Unit(benchmark::kMillisecond);

// Arguments: semi-global or block matching, all disparities or those near which anything is seen,
// pixels of a side that are made one.
void BM_StereoMatching(benchmark::State& state) {
  perception::StereoOptions options;
  if (state.range(0) == 1) options.method = perception::StereoMethod::kBlockMatching;
  options.narrow_search = state.range(1) == 1;
  const int binning = static_cast<int>(state.range(2));
  for (auto _ : state) {
    benchmark::DoNotOptimize(perception::match_stereo(
        perception::binned(chain().images.left, binning),
        perception::binned(chain().images.right, binning),
        perception::binned(chain().scene.camera.camera, binning), options));
  }
}
BENCHMARK(BM_StereoMatching)
    ->Unit(benchmark::kMillisecond)
    ->ArgNames({"block", "narrow", "binning"})
    ->ArgsProduct({{0, 1}, {0, 1}, {1, 2}});

void BM_Segmentation(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(perception::segment(chain().cloud_C, chain().scene.camera.camera.left,
                                                 chain().scene.camera.X_WC()));
  }
  state.counters["objects"] = static_cast<double>(chain().segmented.objects.size());
}
BENCHMARK(BM_Segmentation)->Unit(benchmark::kMillisecond);

void BM_Completion(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(chain().complete());
  state.counters["points"] =
      static_cast<double>(chain().segmented.objects.at(chain().target).cloud_W.size());
}
BENCHMARK(BM_Completion)->Unit(benchmark::kMillisecond);

void BM_Meshing(benchmark::State& state) {
  for (auto _ : state) {
    benchmark::DoNotOptimize(surface::make_object_model(chain().shape, chain().segmented.table_W));
  }
  state.counters["triangles"] = static_cast<double>(chain().model.mesh_W.triangles.size());
}
BENCHMARK(BM_Meshing)->Unit(benchmark::kMillisecond);

void BM_GraspPlanning(benchmark::State& state) {
  std::size_t kept = 0;
  for (auto _ : state) {
    const auto plan = chain().plan();
    kept = plan.grasps.size();
    benchmark::DoNotOptimize(plan);
  }
  state.counters["grasps"] = static_cast<double>(kept);
}
BENCHMARK(BM_GraspPlanning)->Unit(benchmark::kMillisecond);

void BM_SimulationStepAtRest(benchmark::State& state) {
  simulation::World world(chain().scene);
  for (auto _ : state) world.step();
  // Simulated seconds for each second spent.
  state.counters["real_time_factor"] =
      benchmark::Counter(chain().scene.step, benchmark::Counter::kIsIterationInvariantRate);
}
BENCHMARK(BM_SimulationStepAtRest)->Unit(benchmark::kMicrosecond);

}  // namespace
