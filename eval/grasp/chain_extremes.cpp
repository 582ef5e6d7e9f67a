#include "eval/grasp/chain_extremes.h"

#include <algorithm>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace prehend::eval {
namespace {

ExtremeAxis axis(std::string name, std::string unit, double ExtremeCase::*value, double scale,
                 std::vector<double> values) {
  return {std::move(name), std::move(unit), value, scale, std::move(values)};
}

ExtremeAxis points(std::vector<double> values) {
  return axis("points of the picture", "", &ExtremeCase::points, 1, std::move(values));
}
ExtremeAxis size(std::vector<double> values) {
  return axis("object's size", "mm", &ExtremeCase::size, 1e3, std::move(values));
}
ExtremeAxis distance(std::vector<double> values) {
  return axis("distance", "m", &ExtremeCase::distance, 1, std::move(values));
}
ExtremeAxis noise(std::vector<double> values) {
  return axis("noise", "mm", &ExtremeCase::noise, 1e3, std::move(values));
}
ExtremeAxis outliers(std::vector<double> values) {
  return axis("outliers", "%", &ExtremeCase::outliers, 100, std::move(values));
}
ExtremeAxis tilt(std::vector<double> values) {
  return axis("table's tilt", "degrees", &ExtremeCase::tilt, 1, std::move(values));
}
ExtremeAxis elevation(std::vector<double> values) {
  return axis("view over the table", "degrees", &ExtremeCase::elevation, 1, std::move(values));
}
ExtremeAxis mass(std::vector<double> values) {
  return axis("mass", "kg", &ExtremeCase::mass, 1, std::move(values));
}
ExtremeAxis friction(std::vector<double> values) {
  return axis("friction", "", &ExtremeCase::friction, 1, std::move(values));
}

ExtremeGrid coarse_grid() {
  ExtremeGrid grid;
  grid.objects = {"can"};
  grid.seeds = {1};
  grid.axes = {points({1e2, 1e6}), size({0.005, 1}),     distance({0.2, 3}),
               noise({0, 0.01}),   outliers({0.1, 0.5}), tilt({15, 45}),
               elevation({5, 85}), mass({0.001, 10}),    friction({0.05, 2})};
  return grid;
}

}  // namespace

std::string ExtremeAxis::text(std::size_t i) const {
  const double shown = scale * values.at(i);
  if (shown >= 1e4) return fmt::format("{:.0e}", shown);
  return fmt::format("{:.4g}", shown);
}

ExtremeGrid extreme_grid(bool coarse) {
  if (coarse) return coarse_grid();
  ExtremeGrid grid;
  grid.objects = {"can", "milk_carton", "spray_bottle"};
  grid.seeds = {1, 2};
  grid.axes = {
      points({1e2, 1e3, 1e4, 1e5, 1e6, 1e7}),   size({0.005, 0.01, 0.02, 0.05, 0.1, 0.25, 0.5, 1}),
      distance({0.2, 0.4, 0.7, 1, 1.5, 2, 3}),  noise({0, 0.001, 0.002, 0.005, 0.01}),
      outliers({0, 0.01, 0.05, 0.1, 0.2, 0.5}), tilt({0, 5, 15, 30, 45}),
      elevation({5, 15, 25, 40, 60, 75, 85}),   mass({0.001, 0.01, 0.1, 1, 3, 10}),
      friction({0.05, 0.1, 0.3, 0.7, 1, 2})};
  grid.pairs = {{noise({0, 0.002, 0.005, 0.01}), outliers({0, 0.01, 0.1, 0.5})},
                {size({0.02, 0.05, 0.1, 0.5}), distance({0.2, 0.7, 1.5, 3})},
                {points({1e3, 1e4, 1e5, 1e6}), noise({0, 0.002, 0.005, 0.01})},
                {elevation({5, 15, 40, 85}), distance({0.4, 0.7, 1.5, 3})},
                {mass({0.001, 0.2, 3, 10}), friction({0.05, 0.3, 0.7, 2})}};
  return grid;
}

std::vector<ExtremeCase> ExtremeGrid::cases() const {
  std::vector<ExtremeCase> cases;
  std::set<std::string> names;
  const auto add = [&](ExtremeCase one) {
    for (const std::string& object : objects) {
      for (const std::uint64_t seed : seeds) {
        one.object = object;
        one.seed = seed;
        if (names.insert(one.name()).second) cases.push_back(one);
      }
    }
  };
  for (const ExtremeAxis& axis : axes) {
    for (const double value : axis.values) {
      ExtremeCase one;
      one.*axis.value = value;
      add(one);
    }
  }
  for (const ExtremePair& pair : pairs) {
    for (const double row : pair.rows.values) {
      for (const double column : pair.columns.values) {
        ExtremeCase one;
        one.*pair.rows.value = row;
        one.*pair.columns.value = column;
        add(one);
      }
    }
  }
  return cases;
}

ExtremeTotals totals(const std::vector<ExtremeCase>& cases, const ExtremeResults& results) {
  ExtremeTotals totals;
  for (const ExtremeCase& one : cases) {
    ++totals.cases;
    const auto found = results.find(one.name());
    if (found == results.end()) {
      ++totals.crashed;
      continue;
    }
    const ExtremeResult& result = found->second;
    totals.works += result.outcome == ExtremeOutcome::kWorks;
    totals.refused += result.outcome == ExtremeOutcome::kRefused;
    totals.said += result.outcome == ExtremeOutcome::kSaid;
    totals.silent += result.outcome == ExtremeOutcome::kSilent;
    totals.sure += result.confidence >= kConfident;
    totals.without_a_reason += result.outcome != ExtremeOutcome::kWorks && result.message.empty();
  }
  return totals;
}

}  // namespace prehend::eval
