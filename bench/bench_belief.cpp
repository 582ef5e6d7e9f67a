// What it costs to take in what was felt: contacts and swept space, and the surface that comes of
// it, beside the surface alone.

#include <benchmark/benchmark.h>

#include "prehend/belief/attempt_memory.h"
#include "prehend/belief/probe.h"
#include "prehend/geometry/mesh_query.h"
#include "prehend/robot/robot_files.h"
#include "prehend/shape/symmetry.h"
#include "prehend/surface/model.h"
#include "tests/shape/synthetic_view.h"

namespace {

using namespace prehend;

shape::CompletedShape predicted_box() {
  const auto truth = shape::standing(geometry::make_box({0.06, 0.09, 0.12}), 0.3);
  const shape::SyntheticView view = shape::synthetic_view(truth, {.depth_noise = 0.0005});
  shape::CompletionOptions options;
  options.alternatives = 4;
  options.other_methods = true;
  return shape::complete_by_symmetry(view.view(), options);
}

const shape::CompletedShape& box() {
  static const shape::CompletedShape shape = predicted_box();
  return shape;
}

const geometry::Plane kTable{Eigen::Vector3d::UnitZ(), 0};

/// A belief that was told of so many touches, each on the way to where most is to be learnt.
belief::ObjectBelief touched(int resolution, int touches) {
  belief::BeliefOptions options;
  options.surface.fast_poisson.resolution = resolution;
  belief::ObjectBelief belief(box(), kTable, options);
  const belief::ProbeOptions probing;
  for (int i = 0; i < touches; ++i) {
    const auto probe = belief::best_probe(belief, probing);
    if (!probe) break;
    const Eigen::Vector3d out = (probe->start_W - probe->end_W).normalized();
    const Eigen::Vector3d felt = probe->at_W - 0.003 * out;
    belief.begin_act({0.001, 0.01});
    belief::add_probe(*probe, felt + probing.radius * out, belief::Contact{felt, out},
                      probing.radius, &belief);
    belief.update();
  }
  return belief;
}

/// range(0): nodes of the surface's grid; range(1): touches.
void BM_Update(benchmark::State& state) {
  belief::ObjectBelief belief =
      touched(static_cast<int>(state.range(0)), static_cast<int>(state.range(1)));
  for (auto _ : state) {
    belief.update();
    benchmark::DoNotOptimize(belief.mesh());
  }
  state.counters["shapes"] = static_cast<double>(belief.shapes().size());
  state.counters["contacts"] = static_cast<double>(belief.contacts().size());
}
BENCHMARK(BM_Update)
    ->ArgsProduct({{64, 128}, {0, 1, 5, 20}})
    ->ArgNames({"resolution", "touches"})
    ->Unit(benchmark::kMillisecond);

/// Without the surface.
void BM_Weigh(benchmark::State& state) {
  belief::ObjectBelief belief = touched(64, static_cast<int>(state.range(0)));
  for (auto _ : state) belief.update();
}
BENCHMARK(BM_Weigh)->Arg(1)->Arg(5)->Arg(20)->ArgName("touches")->Unit(benchmark::kMillisecond);

void BM_BestProbe(benchmark::State& state) {
  const belief::ObjectBelief belief = touched(64, 2);
  for (auto _ : state) benchmark::DoNotOptimize(belief::best_probe(belief));
}
BENCHMARK(BM_BestProbe)->Unit(benchmark::kMillisecond);

/// What a look costs before anything is felt.
void BM_FirstBelief(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(belief::ObjectBelief(box(), kTable));
}
BENCHMARK(BM_FirstBelief)->Unit(benchmark::kMillisecond);

/// All that the node does when a touched object is seen again: it is found, the belief is made anew
/// of what is seen now, and told what was felt; the corrected model with its convex pieces.
void BM_Recall(benchmark::State& state) {
  belief::AttemptMemory memory(robot::read_hand_model("config/robots/pg70.yaml"));
  belief::Act act;
  act.contacts.push_back({{-0.03, 0, 0.06}, -Eigen::Vector3d::UnitX(), 0.0007});
  memory.add({act}, box(), kTable, surface::mesh_of(box(), kTable));
  for (auto _ : state) {
    auto known = memory.recall(box(), kTable);
    if (!known) state.SkipWithError("the box is not found again");
    benchmark::DoNotOptimize(known);
  }
}
BENCHMARK(BM_Recall)->Unit(benchmark::kMillisecond);

/// Of it: the model of a mesh that is known already.
void BM_ModelOfShape(benchmark::State& state) {
  const geometry::TriangleMesh mesh_W = surface::mesh_of(box(), kTable);
  for (auto _ : state) benchmark::DoNotOptimize(surface::model_of_shape(mesh_W, box()));
}
BENCHMARK(BM_ModelOfShape)->Unit(benchmark::kMillisecond);

}  // namespace
