// The whole chain of a plan: from a completed cloud to a ranked plan with the arm's motion.

#include <algorithm>
#include <chrono>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "prehend/grasp/planner.h"
#include "prehend/planning/platform_pick.h"
#include "prehend/planning/touch_prediction.h"
#include "prehend/robot/platform.h"
#include "prehend/shape/symmetry.h"
#include "prehend/surface/model.h"
#include "tests/shape/synthetic_view.h"

namespace {

using namespace prehend;

/// One view of a carton of 50 x 60 x 120 mm on a table before the arm, completed by symmetry.
struct Completed {
  shape::SyntheticView view = shape::synthetic_view(
      shape::standing(geometry::make_box({0.05, 0.06, 0.12}), 0.5), {.distance = 0.45});
  shape::CompletedShape shape = shape::complete_by_symmetry(view.view());
};

std::vector<planning::PlatformGrasp> ranked_grasps(const surface::ObjectModel& object,
                                                   const geometry::Plane& table_W,
                                                   const robot::Platform& platform,
                                                   const grasp::HandToClose& hand, int threads,
                                                   bool all_candidates) {
  grasp::PlannerOptions options = grasp::default_options(platform.hand);
  options.threads = threads;
  if (all_candidates) options.enough_grasps = 0;
  if (!platform.hand.gripper) options = planning::within_reach(std::move(options), platform);
  std::vector<planning::PlatformGrasp> grasps;
  for (const auto& grasp : grasp::plan_grasps(object, table_W, {}, hand, {}, options).grasps) {
    grasps.push_back(planning::to_pick(grasp));
  }
  return grasps;
}

/// Ranked grasps, robustness included, and reach, approach and lift for the best that the arm can
/// execute. The robot is read before, as in a node. `coarse`: from points thinned to 3 mm, on 64
/// nodes. `all`: every candidate is tried, also where enough grasps are sure before.
void chain(benchmark::State& state, const std::string& name) {
  static const Completed completed;
  const robot::Platform platform = robot::read_platform("config/robots/" + name + ".yaml");
  const grasp::HandToClose hand(platform.hand);
  const int threads = static_cast<int>(state.range(0));
  surface::ModelOptions meshing;
  if (state.range(1) == 1) {
    meshing.cloud.spacing = 0.003;
    meshing.surface.fast_poisson.resolution = 64;
  }
  std::size_t triangles = 0;
  double mesh = 0, grasping = 0, motion = 0;
  int found = 0;
  auto last = std::chrono::steady_clock::now();
  const auto lap = [&last](double* sum) {
    const auto now = std::chrono::steady_clock::now();
    *sum += std::chrono::duration<double>(now - last).count();
    last = now;
  };
  for (auto _ : state) {
    double between = 0;
    lap(&between);
    const surface::ObjectModel object =
        surface::make_object_model(completed.shape, completed.view.table_W, meshing);
    triangles = object.mesh_W.triangles.size();
    lap(&mesh);
    const auto grasps =
        ranked_grasps(object, completed.view.table_W, platform, hand, threads, state.range(2) == 1);
    lap(&grasping);
    const planning::PlatformPick pick =
        planning::plan_platform_pick(platform, platform.home("home").arm, grasps,
                                     {completed.view.table_W, object.convex_pieces_W, {}});
    lap(&motion);
    found += pick.motion.found();
  }
  const double each = 1e3 / static_cast<double>(state.iterations());
  state.counters["mesh_ms"] = each * mesh;
  state.counters["grasps_ms"] = each * grasping;
  state.counters["motion_ms"] = each * motion;
  state.counters["triangles"] = static_cast<double>(triangles);
  state.counters["found"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}
/// What the pads of the SDH-2 feel on the completed carton: one world, three grasps.
void BM_PredictTouchSdh(benchmark::State& state) {
  static const Completed completed;
  const robot::Platform platform = robot::read_platform("config/robots/kr5_sdh.yaml");
  const surface::ObjectModel object =
      surface::make_object_model(completed.shape, completed.view.table_W, {});
  const grasp::HandToClose hand(platform.hand);
  grasp::GraspPlan plan =
      grasp::plan_grasps(object, completed.view.table_W, {}, hand, {},
                         planning::within_reach(grasp::default_options(platform.hand), platform));
  plan.grasps.resize(std::min<std::size_t>(plan.grasps.size(), 3));
  planning::TouchPredictionOptions options;
  options.threads = 1;
  int predicted = 0;
  for (auto _ : state) {
    for (const auto& touch : planning::add_touch(platform.hand, object, completed.view.table_W,
                                                 options, &plan.grasps)) {
      predicted += touch.outcome == planning::TouchOutcome::kPredicted;
    }
  }
  state.counters["triangles"] = static_cast<double>(object.mesh_W.triangles.size());
  state.counters["grasps"] = static_cast<double>(plan.grasps.size());
  state.counters["predicted"] =
      static_cast<double>(predicted) / static_cast<double>(state.iterations());
}
BENCHMARK(BM_PredictTouchSdh)->Unit(benchmark::kMillisecond);

void BM_CloudToPlanPg70(benchmark::State& state) { chain(state, "kr5_pg70"); }
void BM_CloudToPlanSdh(benchmark::State& state) { chain(state, "kr5_sdh"); }
void BM_CloudToPlanBarrett(benchmark::State& state) { chain(state, "pa10_barrett"); }
void with_threads(benchmark::internal::Benchmark* one) {
  one->ArgNames({"threads", "coarse", "all"})->ArgsProduct({{1, 2}, {0, 1}, {0}});
  one->Args({1, 0, 1});
  one->MeasureProcessCPUTime()->UseRealTime();
  one->Unit(benchmark::kMillisecond);
}
BENCHMARK(BM_CloudToPlanPg70)->Apply(with_threads);
BENCHMARK(BM_CloudToPlanSdh)->Apply(with_threads);
BENCHMARK(BM_CloudToPlanBarrett)->Apply(with_threads);

}  // namespace
