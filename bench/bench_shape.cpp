// The symmetry vote at the two sizes of Bohg et al. (ICRA 2011), who report 16.46 s for 39,416
// points and 0.31 s for 2,100, with 35 hypotheses each; the reference and the fast vote in one run.

#include <algorithm>
#include <ctime>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <benchmark/benchmark.h>
#include <hwy/highway.h>

#include "prehend/shape/fast_vote.h"
#include "prehend/shape/symmetry.h"
#include "tests/oracles/reference_vote.h"
#include "tests/shape/synthetic_view.h"

namespace {

using namespace prehend;
using namespace prehend::shape;

constexpr int kOrientations = 7, kShifts = 5;
constexpr double kMaxAngle = 0.349066;  // 20 deg

geometry::TriangleMesh true_box() { return standing(geometry::make_box({0.06, 0.09, 0.12}), 0.3); }

/// A box of 0.6 litres over its edge in a 640 x 480 image, exactly `points` of its points.
const SyntheticView& view_of(int points) {
  static std::map<int, SyntheticView> views;
  const auto found = views.find(points);
  if (found != views.end()) return found->second;
  SyntheticView view = synthetic_view(true_box(), {.distance = 0.42, .depth_noise = 0.001});
  const auto& all = view.cloud_W.points;
  std::vector<Eigen::Vector3f> kept;
  for (int i = 0; i < points; ++i) kept.push_back(all.at(i * all.size() / points));
  view.cloud_W.points = std::move(kept);
  return views.emplace(points, std::move(view)).first->second;
}

/// Seconds of this thread's core that `work` takes, whatever else the machine does.
double seconds(const std::function<void()>& work) {
  const auto now = [] {
    timespec time{};
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
    return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
  };
  const double start = now();
  work();
  return now() - start;
}

std::vector<geometry::Plane> planes_of(const ObjectView& view) {
  return reference_hypotheses(view, kOrientations, kShifts, kMaxAngle);
}

struct ReferenceSeconds {
  double stage;  // images for each hypothesis, as in the paper
  double votes;  // the images once, then votes alone
};

const ReferenceSeconds& reference_seconds(int points) {
  static std::map<int, ReferenceSeconds> known;
  const auto found = known.find(points);
  if (found != known.end()) return found->second;
  const ObjectView view = view_of(points).view();
  const auto planes = planes_of(view);
  ReferenceSeconds result{};
  result.stage = seconds([&] { benchmark::DoNotOptimize(reference_votes(view, planes, {})); });
  const SeenImages images = reference_images(view);
  result.votes = seconds([&] {
    for (const auto& plane : planes) {
      benchmark::DoNotOptimize(reference_tally(view, images, plane, {}));
    }
  });
  return known.emplace(points, result).first->second;
}

std::vector<Eigen::Vector3d> points_in_camera(const ObjectView& view) {
  std::vector<Eigen::Vector3d> points_C;
  points_C.reserve(view.cloud_W.size());
  const geometry::RigidTransform X_CW = view.X_WC.inverse();
  for (const auto& p_W : view.cloud_W.points) points_C.push_back(X_CW * p_W.cast<double>());
  return points_C;
}

FastVote fast_vote(const ObjectView& view, const std::vector<geometry::Plane>& planes) {
  return {points_in_camera(view),
          view.camera,
          make_seen_map(view, window_of_mirrored(view, planes)),
          {}};
}

void report(benchmark::State& state, double reference, double iteration_seconds, int points) {
  state.counters["reference_ms"] = 1e3 * reference;
  state.counters["times_reference"] = reference / iteration_seconds;
  state.counters["ns_per_mirrored_point"] =
      1e9 * iteration_seconds / (static_cast<double>(points) * kOrientations * kShifts);
}

void BM_ReferenceStage(benchmark::State& state) {
  const int points = static_cast<int>(state.range(0));
  for (auto _ : state) state.SetIterationTime(reference_seconds(points).stage);
}
BENCHMARK(BM_ReferenceStage)
    ->Arg(39416)
    ->Arg(2100)
    ->Iterations(1)
    ->UseManualTime()
    ->Unit(benchmark::kMillisecond);

/// From the view to 35 tallies, set-up and all; against the reference's stage.
void BM_FastStage(benchmark::State& state) {
  const int points = static_cast<int>(state.range(0));
  const ObjectView view = view_of(points).view();
  double spent = 0;
  for (auto _ : state) {
    const double once = seconds([&] {
      check_view(view);
      const auto planes = planes_of(view);
      benchmark::DoNotOptimize(fast_vote(view, planes).tallies(planes));
    });
    spent += once;
    state.SetIterationTime(once);
  }
  report(state, reference_seconds(points).stage, spent / state.iterations(), points);
}
BENCHMARK(BM_FastStage)->Arg(39416)->Arg(2100)->UseManualTime()->Unit(benchmark::kMillisecond);

/// The votes alone, with each instruction set of this processor; against the reference's votes.
void fast_votes(benchmark::State& state, std::int64_t target, int points) {
  hwy::SetSupportedTargetsForTest(target);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
  const ObjectView view = view_of(points).view();
  const auto planes = planes_of(view);
  const FastVote vote = fast_vote(view, planes);
  double spent = 0;
  for (auto _ : state) {
    const double once = seconds([&] { benchmark::DoNotOptimize(vote.tallies(planes)); });
    spent += once;
    state.SetIterationTime(once);
  }
  report(state, reference_seconds(points).votes, spent / state.iterations(), points);
  hwy::SetSupportedTargetsForTest(0);
  hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

/// The whole completion at several thinnings (in thousandths of the extent; 0: every point votes):
/// milliseconds, and what is lost as distances of the predicted points to the true surface.
void BM_Complete(benchmark::State& state) {
  const ObjectView view = view_of(static_cast<int>(state.range(0))).view();
  CompletionOptions options;
  options.thinning = 1e-3 * static_cast<double>(state.range(1));
  CompletedShape shape;
  for (auto _ : state) shape = complete_by_symmetry(view, options);
  const geometry::MeshQuery truth(true_box());
  std::vector<double> distances;
  for (std::size_t i = view.cloud_W.size(); i < shape.cloud_W.size(); i += 7) {
    distances.push_back(truth.nearest(shape.cloud_W.points[i].cast<double>())->distance);
  }
  std::sort(distances.begin(), distances.end());
  state.counters["median_error_mm"] = 1e3 * distances.at(distances.size() / 2);
  state.counters["error_95_mm"] = 1e3 * distances.at(distances.size() * 95 / 100);
  state.counters["vote"] = shape.symmetry.vote;
}
BENCHMARK(BM_Complete)
    ->ArgsProduct({{39416, 2100}, {0, 5, 10, 20, 40, 80}})
    ->ArgNames({"points", "thinning"})
    ->Unit(benchmark::kMillisecond);

const bool registered = [] {
  for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
    for (const int points : {39416, 2100}) {
      benchmark::RegisterBenchmark(
          ("BM_FastVotes/" + std::string(hwy::TargetName(target)) + "/" + std::to_string(points))
              .c_str(),
          fast_votes, target, points)
          ->UseManualTime()
          ->Unit(benchmark::kMillisecond);
    }
  }
  return true;
}();

}  // namespace
