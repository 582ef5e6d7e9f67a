// What a plan is made of, beside its peers in the same run: closure and quality of a grasp against
// GLPK's linear programme and Qhull's whole hull; inverse kinematics.

#include <algorithm>
#include <array>
#include <ctime>
#include <random>
#include <string>
#include <vector>

#include <benchmark/benchmark.h>

#include "prehend/grasp/wrench/force_closure.h"
#include "prehend/grasp/wrench/wrench_hull.h"
#include "prehend/motion/checker_registry.h"
#include "prehend/motion/plan_path.h"
#include "prehend/motion/planner_registry.h"
#include "prehend/robot/inverse_kinematics.h"
#include "prehend/robot/platform.h"
#include "tests/motion/pick_scene.h"
#include "tests/motion/shelves.h"
#include "tests/robot/arms.h"

namespace {

using namespace prehend;

constexpr int kGrasps = 64;

/// Closed grasps of five point contacts on a ball, friction 0.5.
const std::vector<std::vector<grasp::Contact>>& grasps() {
  static const auto all = [] {
    std::mt19937_64 random(1);
    const auto uniform = [&random] { return 2 * robot::uniform(random) - 1; };
    std::vector<std::vector<grasp::Contact>> result;
    while (result.size() < kGrasps) {
      std::vector<grasp::Contact> contacts;
      for (int i = 0; i < 5; ++i) {
        const Eigen::Vector3d out = Eigen::Vector3d(uniform(), uniform(), uniform()).normalized();
        contacts.push_back({0.04 * out, -out, 0.5, 0});
      }
      const auto w = grasp::primitive_wrenches(contacts, Eigen::Vector3d::Zero(), 0.04, 8);
      if (grasp::wrench_hull(w).closed) result.push_back(contacts);
    }
    return result;
  }();
  return all;
}

const std::vector<grasp::Wrenches>& wrenches() {
  static const auto all = [] {
    std::vector<grasp::Wrenches> result;
    for (const auto& contacts : grasps()) {
      result.push_back(grasp::primitive_wrenches(contacts, Eigen::Vector3d::Zero(), 0.04, 8));
    }
    return result;
  }();
  return all;
}

/// Seconds of processor time for each of `items`.
template <class Items, class Function>
double seconds_each(const Items& items, Function f) {
  const std::clock_t start = std::clock();
  for (const auto& item : items) benchmark::DoNotOptimize(f(item));
  return static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC /
         static_cast<double>(items.size());
}

double qhull_seconds() {
  static const double seconds = seconds_each(
      wrenches(), [](const grasp::Wrenches& w) { return grasp::reference_wrench_hull(w).epsilon; });
  return seconds;
}

/// The closure's programme, and the twelve of the quality.
double programme_seconds() {
  static const double seconds = seconds_each(grasps(), [](const auto& contacts) {
    return grasp::evaluate_force_closure(contacts, Eigen::Vector3d::Zero(), 0.04).margin;
  });
  return seconds;
}

template <class Function>
void each_hull(benchmark::State& state, Function f) {
  std::size_t i = 0;
  for (auto _ : state) benchmark::DoNotOptimize(f(wrenches()[i++ % kGrasps]));
}

void compare(benchmark::State& state, const char* name, double seconds) {
  state.counters[name] = {seconds, benchmark::Counter::kIsIterationInvariantRate};
}

void BM_PreFilter(benchmark::State& state) { each_hull(state, grasp::may_be_closed); }
BENCHMARK(BM_PreFilter)->Unit(benchmark::kMicrosecond);

void BM_Closure(benchmark::State& state) {
  each_hull(state, [](const grasp::Wrenches& w) {
    return grasp::wrench_hull(w, {.closure_only = true}).closed;
  });
  compare(state, "times_qhull", qhull_seconds());
  compare(state, "times_13_programmes", programme_seconds());
}
BENCHMARK(BM_Closure)->Unit(benchmark::kMicrosecond);

void BM_Epsilon(benchmark::State& state) {
  int facets = 0;
  each_hull(state, [&facets](const grasp::Wrenches& w) {
    const grasp::WrenchHull hull = grasp::wrench_hull(w);
    facets = std::max(facets, hull.facets);
    return hull.epsilon;
  });
  state.counters["most_facets"] = facets;
  compare(state, "times_qhull", qhull_seconds());
}
BENCHMARK(BM_Epsilon)->Unit(benchmark::kMicrosecond);

void BM_Qhull(benchmark::State& state) {
  each_hull(state,
            [](const grasp::Wrenches& w) { return grasp::reference_wrench_hull(w).epsilon; });
}
BENCHMARK(BM_Qhull)->Unit(benchmark::kMicrosecond);

/// All branches for random poses within reach and limits.
void inverse(benchmark::State& state, const robot::KinematicChain& arm, int elbow_angles) {
  const robot::InverseKinematics inverse_kinematics(arm, {.elbow_angles = elbow_angles});
  std::mt19937_64 random(2);
  std::vector<geometry::RigidTransform> targets;
  for (int i = 0; i < 256; ++i) {
    targets.push_back(arm.forward(robot::random_positions(arm, random)));
  }
  std::size_t i = 0, solutions = 0;
  for (auto _ : state) {
    solutions += inverse_kinematics.solve(targets[i++ % targets.size()]).solutions.size();
  }
  state.counters["solutions"] =
      static_cast<double>(solutions) / static_cast<double>(state.iterations());
}

void BM_InverseKinematicsKr5(benchmark::State& state) { inverse(state, robot::kr5(), 1); }
BENCHMARK(BM_InverseKinematicsKr5)->Unit(benchmark::kMicrosecond);

void BM_InverseKinematicsKr5Batch(benchmark::State& state) {
  const robot::KinematicChain arm = robot::kr5();
  const robot::InverseKinematics inverse_kinematics(arm);
  std::mt19937_64 random(2);
  std::vector<geometry::RigidTransform> targets;
  for (int i = 0; i < 256; ++i) {
    targets.push_back(arm.forward(robot::random_positions(arm, random)));
  }
  std::vector<robot::InverseSolutions> answers;
  for (auto _ : state) inverse_kinematics.solve_batch(targets, arm.middle(), answers);
  state.counters["each"] = {
      256, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert};
}
BENCHMARK(BM_InverseKinematicsKr5Batch)->Unit(benchmark::kMicrosecond);

void BM_InverseKinematicsPa10(benchmark::State& state) {
  inverse(state, robot::pa10(), static_cast<int>(state.range(0)));
}
BENCHMARK(BM_InverseKinematicsPa10)
    ->ArgName("elbow_angles")
    ->Arg(1)
    ->Arg(16)
    ->Unit(benchmark::kMicrosecond);

void BM_ForwardKinematics(benchmark::State& state) {
  const robot::KinematicChain arm = robot::kr5();
  const robot::Positions q = arm.middle();
  for (auto _ : state) benchmark::DoNotOptimize(arm.forward(q));
}
BENCHMARK(BM_ForwardKinematics);

/// Medians of the processor time and of the length of a path.
struct PathCost {
  double seconds = 0, length = 0;
};

/// The PA10 from one compartment of shelves to the other.
template <class Plan>
PathCost median_cost(Plan plan, int count) {
  std::vector<double> seconds, lengths;
  for (int seed = 1; seed <= count; ++seed) {
    const std::clock_t start = std::clock();
    const motion::JointPath path = plan(seed);
    seconds.push_back(static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC);
    lengths.push_back(path.length());
  }
  const auto median = [](std::vector<double>& values) {
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
  };
  return {median(seconds), median(lengths)};
}

struct Task {
  motion::Shelves shelves;
  motion::RobotInWorld robot = shelves.in_world();
  std::vector<robot::Positions> left = shelves.reach(robot, {0.65, 0.22, 0.5});
  std::vector<robot::Positions> right = shelves.reach(robot, {0.65, -0.22, 0.5});
};

const Task& task() {
  static const Task one;
  return one;
}

/// The task's robot with a collision checker.
motion::RobotInWorld robot_by(const std::string& checker) {
  motion::RobotInWorld robot = task().robot;
  robot.use_checker(motion::CheckerRegistry().create(checker),
                    motion::make_robot_shapes(task().shelves.model, "base_link", "tool0"));
  return robot;
}

PathCost path_cost(const std::string& planner_name, const std::string& checker, int count) {
  const auto planner = motion::PlannerRegistry().create(planner_name);
  const motion::RobotInWorld robot = robot_by(checker);
  return median_cost(
      [&](int seed) {
        motion::PathOptions options;
        options.seed = static_cast<std::uint64_t>(seed);
        return motion::plan_path(*planner, robot, task().left.front(), task().right, options);
      },
      count);
}

const PathCost& own_cost() {
  static const PathCost cost = path_cost("rrt_connect", "balls", 200);
  return cost;
}

/// The same question by every planner and checker, as ratios to the own.
void path(benchmark::State& state, const char* planner, const char* checker, int count) {
  PathCost cost;
  for (auto _ : state) {
    cost = path_cost(planner, checker, count);
    state.SetIterationTime(cost.seconds);
  }
  state.counters["times_own"] = cost.seconds / own_cost().seconds;
  state.counters["length"] = cost.length;
  state.counters["length_own"] = own_cost().length;
}
#define PREHEND_PATH(name, planner, checker, count)      \
  BENCHMARK_CAPTURE(path, name, planner, checker, count) \
      ->Iterations(1)                                    \
      ->UseManualTime()                                  \
      ->Unit(benchmark::kMillisecond)
PREHEND_PATH(own, "rrt_connect", "balls", 200);
PREHEND_PATH(ompl_rrt_connect, "ompl_rrt_connect", "balls", 100);
PREHEND_PATH(ompl_bitrrt, "ompl_bitrrt", "balls", 100);
PREHEND_PATH(ompl_kpiece, "ompl_kpiece", "balls", 50);
PREHEND_PATH(fcl, "rrt_connect", "fcl", 25);
PREHEND_PATH(bullet, "rrt_connect", "bullet", 25);

/// One position; random ones, of which each checker calls others free.
void is_free(benchmark::State& state, const char* checker) {
  std::mt19937_64 random(3);
  std::vector<robot::Positions> positions;
  for (int i = 0; i < 256; ++i) {
    positions.push_back(robot::random_positions(task().shelves.chain, random));
  }
  const motion::RobotInWorld robot = robot_by(checker);
  std::size_t i = 0, free = 0;
  for (auto _ : state) free += robot.is_free(positions[i++ % 256]);
  std::size_t k = 0;
  const double own = seconds_each(std::vector<int>(16384),
                                  [&](int) { return task().robot.is_free(positions[k++ % 256]); });
  state.counters["times_own"] = {
      own, benchmark::Counter::kIsIterationInvariantRate | benchmark::Counter::kInvert};
  state.counters["free"] = static_cast<double>(free) / static_cast<double>(state.iterations());
  state.counters["balls"] = static_cast<double>(task().robot.spheres().spheres.size());
}
BENCHMARK_CAPTURE(is_free, balls, "balls");
BENCHMARK_CAPTURE(is_free, fcl, "fcl");
BENCHMARK_CAPTURE(is_free, bullet, "bullet");

/// From a start beside to a box between two others, and with it to the other side.
void pick(benchmark::State& state, const char* arm) {
  motion::PickScene scene(arm, {0.5, 0.2, 0});
  scene.add("left", motion::at(0.5, 0.4, 0.1), {0.1, 0.1, 0.2});
  scene.add("right", motion::at(0.5, -0.02, 0.15), {0.2, 0.05, 0.3});
  scene.task.X_BO_places = {motion::at(0.45, -0.25, 0.081)};
  scene.grasps_from_above();
  scene.grasps_from_the_side(0);
  scene.task.start[0] = -1;
  const motion::RobotInWorld robot = scene.in_world();
  const robot::InverseKinematics inverse = scene.inverse();
  motion::PickOptions options;
  options.acceleration = Eigen::VectorXd::Constant(scene.chain.size(), 5.0);
  int found = 0;
  for (auto _ : state) {
    ++options.path.seed;
    found += motion::plan_pick(robot, inverse, scene.task, options).found();
  }
  state.counters["found"] = static_cast<double>(found) / static_cast<double>(state.iterations());
}
void BM_PickKr5(benchmark::State& state) { pick(state, "kr5"); }
BENCHMARK(BM_PickKr5)->Unit(benchmark::kMillisecond);
void BM_PickPa10(benchmark::State& state) { pick(state, "pa10"); }
BENCHMARK(BM_PickPa10)->Unit(benchmark::kMillisecond);

/// The PA10 among 30 balls of 0.2 m as near as 0.5 m, after VAMP's scene; 8 positions at once.
void BM_EightPositions(benchmark::State& state) {
  std::mt19937_64 random(4);
  const auto uniform = [&random] { return 2 * robot::uniform(random) - 1; };
  motion::CollisionWorld world;
  while (world.obstacles().size() < 30) {
    const Eigen::Vector3d p(1.2 * uniform(), 1.2 * uniform(), 0.4 + uniform());
    if (p.head<2>().norm() > 0.5) world.add_sphere("ball", p, 0.1);
  }
  const motion::RobotInWorld robot(
      task().shelves.chain,
      motion::make_robot_spheres(task().shelves.model, "base_link", "tool0", 0.05), world);
  const bool only_free = state.range(0) == 1;  // nothing ends a test early
  std::vector<std::array<robot::Positions, motion::kBatch>> batches(64);
  for (auto& batch : batches) {
    for (robot::Positions& q : batch) {
      do {
        q = robot::random_positions(task().shelves.chain, random);
      } while (only_free && !robot.is_free(q));
    }
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(robot.not_free(batches[i++ % 64].data(), motion::kBatch));
  }
  std::size_t k = 0;
  const double single = seconds_each(std::vector<int>(4096), [&](int) {
    const auto& batch = batches[k / 8 % 64];
    return robot.is_free(batch[k++ % 8]);
  });
  state.counters["times_one_at_a_time"] = {8 * single,
                                           benchmark::Counter::kIsIterationInvariantRate};
}
BENCHMARK(BM_EightPositions)->ArgName("only_free")->Arg(0)->Arg(1);

/// The Panda with nothing round it, against itself: without or with the pairs of balls that are
/// proven to be kept apart.
void BM_EightPositionsOfItself(benchmark::State& state) {
  const robot::Platform platform = robot::read_platform("config/robots/panda.yaml");
  const robot::KinematicChain chain = platform.arm_chain();
  motion::RobotSpheres spheres = motion::make_robot_spheres(
      platform.with_hand_at(platform.hand.all_positions(platform.hand.preshapes.front().open)),
      platform.base, platform.flange, 0.04);
  if (state.range(0) == 1) {
    spheres.self_pairs.insert(spheres.self_pairs.end(), spheres.apart_pairs.begin(),
                              spheres.apart_pairs.end());
  }
  state.counters["pairs"] = static_cast<double>(spheres.self_pairs.size());
  const motion::RobotInWorld robot(chain, spheres, motion::CollisionWorld());
  std::mt19937_64 random(4);
  std::vector<std::array<robot::Positions, motion::kBatch>> batches(64);
  for (auto& batch : batches) {
    for (robot::Positions& q : batch) q = robot::random_positions(chain, random);
  }
  std::size_t i = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(robot.not_free(batches[i++ % 64].data(), motion::kBatch));
  }
}
BENCHMARK(BM_EightPositionsOfItself)->ArgName("all")->Arg(1)->Arg(0);

}  // namespace
