// Soft contact: texels, steps, the whole work cycle on a box and on a mesh of 100,000 triangles,
// and MuJoCo's pad of 168 contacts in the same run. Times are of the processor, one core.

#include <cmath>
#include <ctime>
#include <map>
#include <optional>

#include <benchmark/benchmark.h>

#include "prehend/contact/pad_kernel.h"
#include "prehend/simulation/engines/registry.h"
#include "prehend/simulation/work_cycle.h"
#include "prehend/simulation/world.h"

namespace {

using namespace prehend;
using namespace prehend::contact;

TexelLaw law() {
  TexelLaw law;
  law.viscous_friction = 0.1;
  law.bristle_law = BristleLaw::kElastoPlastic;
  law.return_map = true;
  return law;
}

// One iteration of a pad's texels: linearisation, sums, new bristles.
void BM_Texels(benchmark::State& state) {
  PadGrid grid;
  grid.rows = static_cast<int>(state.range(0));
  grid.columns = static_cast<int>(state.range(1));
  const PadLayout pad = PadLayout::flat(grid);
  PadState texels(pad);
  std::fill(texels.depth.begin(), texels.depth.end(), 5e-4);
  PadScratch scratch(pad);
  PadResponse response;
  const Vector6 twist = (Vector6() << 1e-4, -2e-4, 0, 0, 0, 1e-3).finished();
  for (auto _ : state) {
    respond(pad, law(), 1e-3, twist, texels, scratch, response);
    advance(pad, law(), 1e-3, twist, texels, scratch);
    benchmark::DoNotOptimize(response.constant);
  }
  state.counters["ns_per_texel"] = benchmark::Counter(
      1e-9 * static_cast<double>(pad.size()),
      benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert);
  state.SetLabel(vector_target());
}
BENCHMARK(BM_Texels)->Args({14, 6})->Args({40, 25})->Args({100, 100});

// A 300 g cube held between two 6 x 14 pads, one step of 1 ms.
std::unique_ptr<GraspStepper> held_cube(Integration integration) {
  ParallelGraspOptions options;
  options.opening = 0.0501;
  options.law = law();
  StepOptions step;
  step.integration = integration;
  auto stepper = std::make_unique<GraspStepper>(parallel_grasp(options), step);
  for (const int slide : {0, 1}) stepper->system().set_command(slide, {.force = 6}, 0);
  stepper->advance(1);
  return stepper;
}

void BM_HeldStep(benchmark::State& state) {
  const auto stepper = held_cube(static_cast<Integration>(state.range(0)));
  for (auto _ : state) stepper->step(1e9);
  state.SetLabel(state.range(0) == static_cast<int>(Integration::kFirstOrder) ? "first order"
                                                                              : "second order");
}
BENCHMARK(BM_HeldStep)
    ->Arg(static_cast<int>(Integration::kFirstOrder))
    ->Arg(static_cast<int>(Integration::kSecondOrder))
    ->Unit(benchmark::kMicrosecond);

// The faces of a cube in a grid, about 100,000 triangles.
geometry::TriangleMesh fine_cube(double size) {
  constexpr int kParts = 91;
  geometry::TriangleMesh mesh;
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, first = static_cast<int>(mesh.vertices.size());
    const double side = face % 2 ? 1 : -1;
    const Eigen::Vector3d n = side * Eigen::Vector3d::Unit(axis);
    const Eigen::Vector3d u = Eigen::Vector3d::Unit((axis + 1) % 3), v = n.cross(u);
    for (int i = 0; i <= kParts; ++i) {
      for (int j = 0; j <= kParts; ++j) {
        mesh.vertices.push_back(0.5 * size * n + size * (1.0 * i / kParts - 0.5) * u +
                                size * (1.0 * j / kParts - 0.5) * v);
      }
    }
    for (int i = 0; i < kParts; ++i) {
      for (int j = 0; j < kParts; ++j) {
        const int a = first + i * (kParts + 1) + j, b = a + kParts + 1;
        mesh.triangles.emplace_back(a, b, b + 1);
        mesh.triangles.emplace_back(a, b + 1, a + 1);
      }
    }
  }
  return mesh;
}

simulation::WorkCycleOptions cycle_options(double mass) {
  simulation::WorkCycleOptions options;
  options.grasp.mass = mass;
  options.grasp.law = law();
  return options;
}

// A second-order run of 0.05 ms steps.
const simulation::WorkCycleResult& reference(double mass) {
  static std::map<double, simulation::WorkCycleResult> known;
  if (!known.count(mass)) {
    simulation::WorkCycleOptions options = cycle_options(mass);
    options.step.integration = Integration::kSecondOrder;
    options.step.step = 5e-5;
    options.sample_period = 0.1;
    known[mass] = run_work_cycle(options);
  }
  return known[mass];
}

// Arguments: integration, 1 for the mesh, grams.
void BM_WorkCycle(benchmark::State& state) {
  const double mass = 1e-3 * static_cast<double>(state.range(2));
  simulation::WorkCycleOptions options = cycle_options(mass);
  options.step.integration = static_cast<Integration>(state.range(0));
  const bool adaptive = options.step.integration == Integration::kAdaptive;
  options.step.step = adaptive ? 1e-4 : 1e-3;
  options.step.tolerance = 1e-6;
  options.step.most_step = 0.5;
  const bool mesh = state.range(1) == 1;
  if (mesh) options.shape = Shape::mesh(fine_cube(0.05));
  double spent = 0, simulated = 0;
  for (auto _ : state) {
    const auto result = run_work_cycle(options);
    spent += result.cpu_time;
    simulated += result.duration;
  }
  options.sample_period = 0.1;
  state.counters["real_time_factor"] = simulated / spent;
  state.counters["error_um"] = 1e6 * largest_difference(run_work_cycle(options), reference(mass));
  state.SetLabel(std::string(adaptive ? "adaptive" : "1 ms") + (mesh ? ", mesh" : ", box"));
}
BENCHMARK(BM_WorkCycle)
    ->ArgsProduct({{static_cast<int>(Integration::kFirstOrder),
                    static_cast<int>(Integration::kAdaptive)},
                   {0, 1},
                   {100, 300, 1000}})
    ->Unit(benchmark::kMillisecond);

// What the node simulation reads for its messages after each slice.
void read_all(const simulation::World& world) {
  benchmark::DoNotOptimize(world.gripper());
  benchmark::DoNotOptimize(world.carrier());
  benchmark::DoNotOptimize(world.wrist_wrench());
  for (const auto side : {simulation::PadSide::kLeft, simulation::PadSide::kRight}) {
    benchmark::DoNotOptimize(world.tactile_image(side));
  }
  for (std::size_t i = 0; i < world.body_count(); ++i) benchmark::DoNotOptimize(world.body(i));
}

struct WorldCycle {
  double spent = 0;                        // s, of the processor
  std::vector<Eigen::Vector3d> places;     // m, of the box at the phases' ends, while it is held
  std::vector<Eigen::Vector4d> in_slices;  // m, of the box in the gripper, and the opening
};

// simulation::World closes, presses, lifts, holds 5 s, puts down, opens and goes: 18 s, in slices
// of `slice` [s] after which all is read; 0: in one piece from command to command. The box is noted
// until the gripper opens: round-off then decides which pad lets go first.
WorldCycle world_cycle(const simulation::Scene& scene, double slice) {
  simulation::World world(scene);
  WorldCycle cycle;
  bool holds = true;
  const auto at = [&](double height) { return scene.carrier.gripper_pose({0, 0, height}, 0); };
  const auto note = [&] {
    Eigen::Vector4d here;
    here << world.carrier().X_WG.inverse() * world.body("box").X_WB.translation(),
        world.gripper().opening;
    cycle.in_slices.push_back(here);
  };
  const auto advance = [&](double seconds) {
    const std::clock_t begin = std::clock();
    if (slice <= 0) world.advance(seconds);
    for (int i = slice > 0 ? static_cast<int>(std::lround(seconds / slice)) : 0; i > 0; --i) {
      world.advance(slice);
      read_all(world);
      if (holds) note();
    }
    cycle.spent += static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
    if (holds) cycle.places.emplace_back(world.body("box").X_WB.translation());
  };
  world.set_gripper_command(simulation::GripperMode::kVelocity, -0.01, 0.4);
  advance(1.5);
  world.set_gripper_command(simulation::GripperMode::kCurrent, -1.0);
  advance(0.5);
  world.move_carrier(at(0.17), 0.05);
  advance(3);
  advance(5);
  world.move_carrier(at(0.0705), 0.05);
  advance(3);
  holds = false;
  world.set_gripper_command(simulation::GripperMode::kPosition, 0.069);
  advance(2);
  world.move_carrier(at(0.3), 0.1);
  advance(3);
  return cycle;
}

template <class Vector>
double largest_difference(const std::vector<Vector>& a, const std::vector<Vector>& b) {
  double worst = 0;
  for (std::size_t i = 0; i < b.size(); ++i) worst = std::max(worst, (a.at(i) - b[i]).norm());
  return worst;
}

simulation::Scene world_cycle_scene() {
  simulation::Scene scene;
  scene.start_opening = 0.06;
  scene.carrier.start = {0, 0, 0.07};
  scene.gripper.pad.law = law();
  simulation::SceneObject box;
  box.name = "box";
  box.size = {0.07, 0.048, 0.1};
  scene.objects.push_back(box);
  return scene;
}

void run_world_cycle(const simulation::Scene& scene, double slice, benchmark::State& state) {
  double spent = 0, simulated = 0;
  WorldCycle cycle;
  for (auto _ : state) {
    cycle = world_cycle(scene, slice);
    spent += cycle.spent;
    simulated += 18;
  }
  static const WorldCycle fine = [] {
    simulation::Scene finest = world_cycle_scene();
    finest.step = 5e-5;
    finest.physics.integration = Integration::kSecondOrder;
    return world_cycle(finest, 0.01);
  }();
  state.counters["real_time_factor"] = simulated / spent;
  state.counters["error_um"] =
      1e6 * (slice > 0 ? largest_difference(cycle.in_slices, fine.in_slices)
                       : largest_difference(cycle.places, fine.places));
}

// Argument: 0 steps of 1 ms, first order; 1 second order; 2 adaptive, 10 um.
void BM_WorldCycle(benchmark::State& state) {
  simulation::Scene scene = world_cycle_scene();
  scene.physics.integration =
      state.range(0) == 1 ? Integration::kSecondOrder : Integration::kFirstOrder;
  scene.physics.adaptive = state.range(0) == 2;
  run_world_cycle(scene, 0, state);
  constexpr const char* kNames[] = {"1 ms, first order", "1 ms, second order", "adaptive, 10 um"};
  state.SetLabel(std::string("World, ") + kNames[state.range(0)]);
}
BENCHMARK(BM_WorldCycle)->Arg(0)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond);

// The same in slices of 10 ms with all readings, as the node simulation does it; the error is that
// of any slice until the gripper opens. Arguments: as above; of fixed steps us, of adaptive ones a
// hundredth of a micrometre.
void BM_WorldSlices(benchmark::State& state) {
  simulation::Scene scene = world_cycle_scene();
  scene.physics.integration =
      state.range(0) == 1 ? Integration::kSecondOrder : Integration::kFirstOrder;
  scene.physics.adaptive = state.range(0) == 2;
  const auto value = static_cast<double>(state.range(1));
  if (scene.physics.adaptive) {
    scene.physics.tolerance = 1e-8 * value;
  } else {
    scene.step = 1e-6 * value;
  }
  run_world_cycle(scene, 0.01, state);
}
BENCHMARK(BM_WorldSlices)
    ->ArgsProduct({{0, 1}, {1000, 500, 200, 100}})
    ->ArgsProduct({{2}, {10000, 1000, 100, 10}})
    ->Unit(benchmark::kMillisecond);

// The same held cube on MuJoCo, each texel a contact; and ours in turn with it.
void BM_HeldStepBesideMujoco(benchmark::State& state) {
  const simulation::engines::EngineRegistry registry;
  if (!registry.has("mujoco")) {
    state.SkipWithError("the plug-in for MuJoCo is not installed");
    return;
  }
  const auto mujoco = registry.create("mujoco");
  const auto native = registry.create("native");
  simulation::engines::EngineScene scene;
  scene.bodies.resize(3);
  scene.bodies[0].name = "cube";
  scene.bodies[0].mass = 0.3;
  for (const int side : {1, -1}) {
    auto& jaw = scene.bodies[side > 0 ? 1 : 2];
    jaw.name = "jaw";
    jaw.mass = 0.05;
    jaw.shape.size = {0.024, 0.012, 0.05};
    jaw.X_WB.translation().y() = side * (0.031 - 1e-5);
    scene.joints.push_back({simulation::engines::EngineJoint::Kind::kPrismatic,
                            -1,
                            side > 0 ? 1 : 2,
                            Eigen::Vector3d(0, -side, 0),
                            {0, 0, 0}});
    simulation::engines::EnginePad pad;
    pad.body = side > 0 ? 1 : 2;
    pad.X_BP.linear().col(1) = Eigen::Vector3d::UnitZ();
    pad.X_BP.linear().col(2) = Eigen::Vector3d(0, -side, 0);
    pad.X_BP.linear().col(0) = pad.X_BP.linear().col(1).cross(pad.X_BP.linear().col(2));
    pad.X_BP.translation().y() = -side * 0.006;
    pad.law = law();
    scene.pads.push_back(pad);
  }
  for (auto* engine : {mujoco.get(), native.get()}) {
    scene.pad_method = engine == mujoco.get() ? simulation::engines::PadMethod::kOwnContacts
                                              : simulation::engines::PadMethod::kTexelLaw;
    engine->load(scene);
    for (const int joint : {0, 1}) engine->set_joint_force(joint, 6);
    for (int i = 0; i < 200; ++i) engine->step();
  }
  double mujoco_time = 0, native_time = 0;
  constexpr int kSteps = 200;
  const auto time = [&](simulation::engines::Engine& engine) {
    const std::clock_t begin = std::clock();
    for (int i = 0; i < kSteps; ++i) engine.step();
    return static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC / kSteps;
  };
  for (auto _ : state) {
    mujoco_time += time(*mujoco);
    for (int k = 0; k < 10; ++k) native_time += 0.1 * time(*native);
  }
  const auto runs = static_cast<double>(state.iterations());
  int touched = 0;
  for (const int pad : {0, 1}) {
    for (const double force : mujoco->pad_forces(pad)) touched += force > 0;
  }
  state.counters["mujoco_us_per_step"] = 1e6 * mujoco_time / runs;
  state.counters["native_us_per_step"] = 1e6 * native_time / runs;
  state.counters["times_faster"] = mujoco_time / native_time;
  state.counters["mujoco_texels_pressed"] = touched;
}
BENCHMARK(BM_HeldStepBesideMujoco)->Unit(benchmark::kMillisecond);

}  // namespace
