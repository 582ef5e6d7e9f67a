// Hands with fingers: what a candidate costs, and a whole plan.

#include <cmath>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "prehend/grasp/closing/finger_closing.h"
#include "prehend/grasp/closing/pad_closing.h"
#include "prehend/grasp/generators/generator_registry.h"
#include "prehend/grasp/planner.h"
#include "prehend/grasp/wrench/force_closure.h"
#include "prehend/grasp/wrench/wrench_hull.h"
#include "prehend/robot/inverse_kinematics.h"
#include "prehend/robot/platform.h"

namespace {

using namespace prehend;
using geometry::RigidTransform;

/// A carton on a table before the arm, with 6 000 triangles.
surface::ObjectModel carton() {
  surface::ObjectModel object;
  object.mesh_W = geometry::make_sphere(0.035, 80);
  for (auto& v : object.mesh_W.vertices) {
    // The ball blown up to a box with rounded edges.
    for (int k = 0; k < 3; ++k) v[k] += (v[k] > 0 ? 1 : -1) * (k == 2 ? 0.02 : 0.002);
    v.z() += 0.055;
  }
  return object;
}

struct Scene {
  explicit Scene(const std::string& name)
      : platform(robot::read_platform("config/robots/" + name + ".yaml")),
        hand(platform.hand),
        arm(platform.arm_chain(), {.elbow_angles = 1}) {}
  bool reaches(const RigidTransform& X_WH) const {
    return !arm.solve(platform.X_WB.inverse() * X_WH * platform.X_FH.inverse()).solutions.empty();
  }
  robot::Platform platform;
  grasp::HandToClose hand;
  robot::InverseKinematics arm;
};

/// Distances of 64 nodes, 2.5 mm apart, 5 to 12 mm from the carton: one search after the other, or
/// all at once.
void distances_of_nodes(benchmark::State& state, bool at_once) {
  const geometry::MeshQuery query(carton().mesh_W);
  const grasp::DistanceBlocks blocks(query);
  constexpr double kCell = 0.0025;
  double angle = 0, sum = 0;
  for (auto _ : state) {
    angle += 0.1;
    const Eigen::Vector3d first(0.044 * std::cos(angle), 0.044 * std::sin(angle), 0.05);
    if (at_once) {
      sum += static_cast<double>(blocks.measure(first, kCell).back());
      continue;
    }
    for (int i = 0; i < 64; ++i) {
      const Eigen::Vector3d p = first + kCell * Eigen::Vector3d(i % 4, i / 4 % 4, i / 16);
      sum += query.nearest(p)->distance;
    }
  }
  benchmark::DoNotOptimize(sum);
  state.SetItemsProcessed(64 * state.iterations());
}
void BM_DistancesOneByOne(benchmark::State& state) { distances_of_nodes(state, false); }
void BM_DistancesOfABlock(benchmark::State& state) { distances_of_nodes(state, true); }
BENCHMARK(BM_DistancesOneByOne)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_DistancesOfABlock)->Unit(benchmark::kMicrosecond);

/// Closing the fingers from where the open hand stands free round the object, closure, and the
/// arm's inverse kinematics: every candidate goes all the way.
void close(benchmark::State& state, const std::string& platform) {
  const Scene scene(platform);
  const geometry::MeshQuery query(carton().mesh_W);
  const grasp::DistanceGrid grid(query);
  const grasp::TouchScene touch{&grid, std::nullopt, nullptr};
  struct Start {
    RigidTransform X_WH;
    const robot::Preshape* preshape;
  };
  std::vector<Start> starts;
  for (const robot::Preshape& preshape : scene.platform.hand.preshapes) {
    const RigidTransform X_GH = (scene.platform.hand.X_HP * preshape.X_PG).inverse();
    for (const auto& candidate : grasp::sample_candidates(
             query.mesh(), {0, 0, 0.055}, geometry::Plane{},
             grasp::hand_reach(scene.hand, preshape).tip_z, {}, {.rolls = 4, .standoffs = 3})) {
      const RigidTransform X_WH = candidate.X_WG * X_GH;
      const auto open = scene.platform.hand.all_positions(preshape.open);
      if (grasp::hand_clearance(scene.hand, X_WH, open, touch).clearance > 0.0015) {
        starts.push_back({X_WH, &preshape});
      }
    }
  }
  std::size_t i = 0, closed = 0;
  std::vector<grasp::Contact> contacts;
  for (auto _ : state) {
    const Start& start = starts[i++ % starts.size()];
    const auto fingers =
        grasp::close_fingers(scene.hand, start.X_WH, *start.preshape, start.preshape->open, touch);
    contacts.clear();
    for (const auto& contact : fingers.contacts) contacts.push_back(contact.contact_W);
    closed += grasp::wrench_hull(grasp::primitive_wrenches(contacts, {0, 0, 0.055}, 0.06, 8),
                                 {.closure_only = true})
                  .closed;
    benchmark::DoNotOptimize(scene.reaches(start.X_WH));
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["closed"] = static_cast<double>(closed) / static_cast<double>(state.iterations());
}
void BM_CandidateSdh(benchmark::State& state) { close(state, "kr5_sdh"); }
void BM_CandidateBarrett(benchmark::State& state) { close(state, "pa10_barrett"); }
BENCHMARK(BM_CandidateSdh)->Unit(benchmark::kMicrosecond);
BENCHMARK(BM_CandidateBarrett)->Unit(benchmark::kMicrosecond);

/// A whole plan from the mesh: all preshapes, all filters, forces of the best.
void plan(benchmark::State& state, const std::string& platform) {
  const Scene scene(platform);
  const surface::ObjectModel object = carton();
  grasp::PlannerOptions options = grasp::default_options(scene.platform.hand);
  options.threads = 1;
  options.reaches = [&scene](const RigidTransform& X_WH) { return scene.reaches(X_WH); };
  int candidates = 0;
  std::size_t grasps = 0;
  for (auto _ : state) {
    const auto result = grasp::plan_grasps(object, geometry::Plane{}, {}, scene.hand, {}, options);
    candidates = result.candidates;
    grasps = result.grasps.size();
  }
  state.SetItemsProcessed(state.iterations() * candidates);
  state.counters["candidates"] = candidates;
  state.counters["grasps"] = static_cast<double>(grasps);
}
void BM_PlanSdh(benchmark::State& state) { plan(state, "kr5_sdh"); }
void BM_PlanBarrett(benchmark::State& state) { plan(state, "pa10_barrett"); }
BENCHMARK(BM_PlanSdh)->Unit(benchmark::kMillisecond);
BENCHMARK(BM_PlanBarrett)->Unit(benchmark::kMillisecond);

/// That the PG70 can close on.
surface::ObjectModel narrow_box() {
  surface::ObjectModel object;
  object.mesh_W = geometry::transformed(
      geometry::make_box({0.05, 0.06, 0.11}),
      geometry::make_transform(Eigen::Quaterniond::Identity(), {0, 0, 0.055}));
  return object;
}

/// The PG70: pads closed on rays, closure, weight, the arm's inverse kinematics; candidates that
/// all get as far as closing.
void BM_CandidatePg70(benchmark::State& state) {
  const Scene scene("kr5_pg70");
  const surface::ObjectModel object = narrow_box();
  grasp::PlannerOptions options;
  const robot::GripperModel gripper;
  const auto& preshape = scene.platform.hand.preshapes.front();
  const grasp::Solid solid = grasp::make_solid(object.mesh_W, options.density);
  const geometry::MeshQuery query_W(solid.mesh_W);
  const grasp::Obstacles nowhere;
  const grasp::Reachability everywhere;
  const grasp::PadClosing evaluator(
      {solid, query_W, geometry::Plane{}, nowhere, scene.hand, everywhere, options});
  std::vector<grasp::Candidate> closing;
  const auto generator = grasp::make_generator("antipodal");
  const grasp::GraspTarget target{
      query_W, solid.center_of_mass_W, {}, evaluator.reach(preshape), {}};
  for (const auto& candidate : generator->generate(target, options.candidates)) {
    grasp::ClosedGrasp evaluated;
    if (!evaluator.evaluate(candidate, preshape, &evaluated)) closing.push_back(candidate);
  }
  std::size_t i = 0;
  for (auto _ : state) {
    grasp::ClosedGrasp evaluated;
    benchmark::DoNotOptimize(evaluator.evaluate(closing[i], preshape, &evaluated));
    benchmark::DoNotOptimize(scene.arm.solve(scene.platform.X_BF(closing[i].X_WG, preshape)));
    i = (i + 1) % closing.size();
  }
  state.SetItemsProcessed(state.iterations());
  state.counters["of"] = static_cast<double>(closing.size());
}
BENCHMARK(BM_CandidatePg70)->Unit(benchmark::kMicrosecond);

/// Predicted things on the rest of the table, half a metre away and more.
grasp::Obstacles neighbours(int count) {
  grasp::Obstacles others;
  for (int i = 0; i < count; ++i) {
    const Eigen::Vector3d p_W(0.5 + 0.15 * (i / 4), 0.15 * (i % 4), 0);
    others.meshes_W.push_back(
        geometry::transformed(carton().mesh_W, RigidTransform(Eigen::Translation3d(p_W))));
  }
  return others;
}

void BM_PlanPg70(benchmark::State& state) {
  const surface::ObjectModel object = narrow_box();
  const grasp::Obstacles others = neighbours(static_cast<int>(state.range(1)));
  const robot::GripperModel gripper;
  grasp::PlannerOptions options;
  options.threads = 1;
  options.generators = {"circles"};
  options.uncertainty.samples = static_cast<int>(state.range(0));
  int candidates = 0;
  for (auto _ : state) {
    candidates =
        grasp::plan_grasps(object, geometry::Plane{}, others, gripper, {}, options).candidates;
  }
  state.SetItemsProcessed(state.iterations() * candidates);
}
BENCHMARK(BM_PlanPg70)
    ->ArgNames({"samples", "neighbours"})
    ->Args({0, 0})
    ->Args({16, 0})
    ->Args({16, 12})
    ->Unit(benchmark::kMillisecond);

}  // namespace
