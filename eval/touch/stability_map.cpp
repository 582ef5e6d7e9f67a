#include "eval/touch/stability_map.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"
#include "prehend/simulation/engines/engine.h"
#include "prehend/simulation/engines/registry.h"

namespace prehend::eval::touch {
namespace {

using Outcome = MapCell::Outcome;

/// Fingers that bear a weight press less: the SDH-2 loses 3 kg where friction would bear 3.9.
constexpr double kOfFriction = 0.75;

/// Runs a cell; what it throws as a refusal is one.
template <class Hold>
MapCell cell_of(const HoldTest& test, const Hold& hold) {
  MapCell cell;
  cell.mass = test.mass;
  cell.step = test.step;
  try {
    hold(cell);
    if (cell.hold.held) {
      cell.outcome = Outcome::kHeld;
    } else if (!cell.why.empty()) {
      cell.outcome = Outcome::kLimit;
    }
  } catch (const std::invalid_argument& error) {
    cell.outcome = Outcome::kRefused;
    cell.why = error.what();
  } catch (const geometry::InputError& error) {
    cell.outcome = Outcome::kRefused;
    cell.why = error.what();
  }
  return cell;
}

/// Why an engine does not hold it; empty: nobody knows of it.
std::string engine_limit(const std::string& engine, const HoldTest& test) {
  const bool coarse = test.step > 5e-3;
  if (engine == "bullet" && coarse) {
    return "Debian's Bullet counts in single precision, and takes the gripper's forces from the "
           "step before: steps of at most 5 ms";
  }
  return {};
}

template <class Hold>
StabilityMap map_of(const std::string& world, bool quick, const Hold& hold) {
  StabilityMap map;
  map.world = world;
  map.masses = {0.01, 0.05, 0.3, 1, 3, 10};
  map.steps = {1e-2, 5e-3, 1e-3, 5e-4, 1e-4};
  if (quick) {
    map.masses = {0.01, 0.3, 3};
    map.steps = {1e-2, 1e-3};
  }
  for (const double mass : map.masses) {
    for (const double step : map.steps) {
      HoldTest test;
      test.mass = mass;
      test.step = step;
      map.cells.push_back(cell_of(test, [&](MapCell& cell) { hold(test, cell); }));
    }
  }
  return map;
}

}  // namespace

int StabilityMap::count(Outcome outcome) const {
  return static_cast<int>(std::count_if(
      cells.begin(), cells.end(), [&](const MapCell& cell) { return cell.outcome == outcome; }));
}

std::vector<StabilityMap> stability_maps(bool quick,
                                         const std::function<void(const std::string&)>& progress) {
  std::vector<StabilityMap> maps;
  const simulation::engines::EngineRegistry registry;
  for (const std::string& engine : registry.names()) {
    progress("PG70 on " + engine);
    maps.push_back(map_of("PG70 on " + engine, quick, [&](const HoldTest& test, MapCell& cell) {
      cell.hold = run_world_hold(engine, test);
      if (!cell.hold.held) cell.why = engine_limit(engine, test);
    }));
  }
  for (const std::string hand : {"sdh2", "bh8"}) {
    progress(hand);
    maps.push_back(map_of(hand, quick, [&](const HoldTest& test, MapCell& cell) {
      const HandHold held = run_hand_hold(hand, test);
      cell.hold = held.hold;
      if (held.hold.held || test.mass < kOfFriction * held.bears) return;
      cell.why = fmt::format(
          "friction bears {:.2g} kg of what its fingers press with, and less as they give way",
          held.bears);
    }));
  }
  return maps;
}

report::CellMap cell_map(const StabilityMap& map) {
  using Kind = report::CellMap::Kind;
  report::CellMap drawn;
  drawn.title = map.world;
  drawn.row_label = "mass [kg]";
  drawn.column_label = "step [ms]";
  for (const double mass : map.masses) drawn.rows.push_back(fmt::format("{:g}", mass));
  for (const double step : map.steps) drawn.columns.push_back(fmt::format("{:g}", 1e3 * step));
  for (const MapCell& cell : map.cells) {
    switch (cell.outcome) {
      case Outcome::kHeld:
        drawn.cells.push_back(
            {Kind::kGood, fmt::format("{:.2g} um", 1e6 * std::abs(cell.hold.slip)), "held"});
        break;
      case Outcome::kLimit:
        drawn.cells.push_back({Kind::kLimit, "limit", cell.why});
        break;
      case Outcome::kLost:
        drawn.cells.push_back({Kind::kBad, "lost", "lost"});
        break;
      case Outcome::kRefused:
        drawn.cells.push_back({Kind::kRefused, "refused", cell.why});
        break;
    }
  }
  return drawn;
}

}  // namespace prehend::eval::touch
