#include "eval/shape_comparison.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace prehend::eval {
namespace {

constexpr double kMostMoved = 0.005;                        // m
constexpr double kMostTurned = 5 * std::numbers::pi / 180;  // rad
constexpr double kLeastStanding = 0.98, kMostSeconds = 0.06;

double back_of(const MethodResult& m) { return m.back_mean; }
double centroid_of(const MethodResult& m) { return m.centroid_error; }
double normals_of(const MethodResult& m) { return m.normal_error; }
double jaccard_of(const MethodResult& m) { return m.jaccard; }
double seconds_of(const MethodResult& m) { return m.seconds; }

const MethodColumn kDeviation = {"deviation [mm]", "mean_deviation_m", 1000, deviation_of};
const MethodColumn kTime = {"time [ms]", "mean_seconds", 1000, seconds_of};

ShapeComparison paper() {
  ShapeComparison comparison;
  comparison.name = "paper";
  comparison.description = "the published methods and ours, by the figures of the paper";
  comparison.methods = {"Ext", "Del", "Mir5", "Mir7", "Ours"};
  comparison.columns = {
      kDeviation,
      {"back [mm]", "mean_back_deviation_m", 1000, back_of},
      {"centroid [%]", "mean_centroid_error", 100, centroid_of},
      {"normals [deg]", "mean_normal_error_rad", 180 / std::numbers::pi, normals_of},
      kTime};
  comparison.judge = judge;
  return comparison;
}

ShapeComparison single_view() {
  ShapeComparison comparison;
  comparison.name = "single_view";
  comparison.description = "ours and the methods of others for one view, of bodies at rest";
  comparison.methods = {"GPIS", "Superquadric", "Mirror", "Mir7", "Ext", "Fast", "Ours", "Truth"};
  comparison.as_solids = true;
  comparison.columns = {{"Chamfer [mm]", "chamfer_m", 1000, chamfer_of},
                        {"Jaccard [%]", "jaccard", 100, jaccard_of},
                        {"Hausdorff [mm]", "hausdorff_m", 1000, hausdorff_of},
                        kDeviation,
                        {"stands [%]", "stands", 100, stands_of, false},
                        kTime};
  comparison.judge = judge_single_view;
  return comparison;
}

std::vector<std::string> rivals_in(const std::vector<CaseResult>& results) {
  std::vector<std::string> rivals;
  for (const CaseResult& result : results) {
    for (const MethodResult& m : result.methods) {
      if (m.method == "Ours" || m.method == "Fast" || m.method == "Truth") continue;
      if (std::find(rivals.begin(), rivals.end(), m.method) == rivals.end()) {
        rivals.push_back(m.method);
      }
    }
  }
  return rivals;
}

// Of the means over all cases; `sign` 1 where less is better, -1 where more is.
Goal best_in(const MethodColumn& column, double sign, const std::vector<CaseResult>& results) {
  Goal goal;
  goal.name = "Ours best in " + column.title;
  goal.bar = "best";
  const double ours = total(results, "Ours", column.figure_of).mean;
  std::string rival;
  double best = kUnknown;
  for (const std::string& method : rivals_in(results)) {
    const double theirs = total(results, method, column.figure_of).mean;
    if (std::isnan(theirs) || sign * theirs >= sign * best) continue;
    best = theirs;
    rival = method;
  }
  if (std::isnan(ours) || rival.empty()) return goal;
  goal.measured =
      fmt::format("{:.2f}, next {:.2f} of {}", column.scale * ours, column.scale * best, rival);
  goal.outcome = sign * ours <= sign * best ? Goal::Outcome::kMet : Goal::Outcome::kMissed;
  return goal;
}

}  // namespace

double chamfer_of(const MethodResult& result) { return 0.5 * (result.mean + result.back_mean); }

double hausdorff_of(const MethodResult& result) {
  return std::isnan(result.max) ? kUnknown : std::max(result.max, result.back_max);
}

double stands_of(const MethodResult& result) {
  return result.moved <= kMostMoved && result.turned <= kMostTurned ? 1 : 0;
}

std::vector<Goal> judge_single_view(const std::vector<CaseResult>& results) {
  std::vector<Goal> goals;
  for (const MethodColumn& column : single_view().columns) {
    if (column.key == kTime.key) continue;
    const bool more_is_better = column.key == "jaccard" || column.key == "stands";
    goals.push_back(best_in(column, more_is_better ? -1 : 1, results));
  }
  // A case without a result of ours is one where nothing stands.
  Goal standing{"Ours stands where the object stood",
                fmt::format(">= {:g} %", 100 * kLeastStanding)};
  const Spread stands = total(results, "Ours", stands_of);
  if (stands.count > 0) {
    const double share = stands.mean * stands.count / static_cast<double>(results.size());
    standing.measured = fmt::format("{:.1f} % of {}", 100 * share, results.size());
    standing.outcome = share >= kLeastStanding ? Goal::Outcome::kMet : Goal::Outcome::kMissed;
  }
  goals.push_back(standing);
  Goal time{"Ours, processor time", fmt::format("<= {:g} ms", 1000 * kMostSeconds)};
  const double seconds = total(results, "Ours", seconds_of).mean;
  if (!std::isnan(seconds)) {
    time.measured = fmt::format("{:.1f} ms", 1000 * seconds);
    time.outcome = seconds <= kMostSeconds ? Goal::Outcome::kMet : Goal::Outcome::kMissed;
  }
  goals.push_back(time);
  return goals;
}

const std::vector<ShapeComparison>& shape_comparisons() {
  static const std::vector<ShapeComparison> list = {paper(), single_view()};
  return list;
}

}  // namespace prehend::eval
