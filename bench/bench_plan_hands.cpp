// Hands with fingers: what a candidate costs, and a whole plan.

#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "prehend/grasp/force_closure.h"
#include "prehend/grasp/hand_planner.h"
#include "prehend/grasp/wrench_hull.h"
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
  grasp::HandPlannerOptions options;
  options.reaches = [&scene](const RigidTransform& X_WH) { return scene.reaches(X_WH); };
  int candidates = 0;
  std::size_t grasps = 0;
  for (auto _ : state) {
    const auto result =
        grasp::plan_hand_grasps(object, geometry::Plane{}, {}, scene.hand, {}, options);
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

}  // namespace
