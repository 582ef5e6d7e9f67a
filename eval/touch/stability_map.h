#pragma once

#include <functional>
#include <string>
#include <vector>

#include "eval/touch/hold.h"
#include "prehend/report/cell_map.h"

namespace prehend::eval::touch {

/// How a hold test of a shipped world ended.
struct MapCell {
  enum class Outcome {
    kHeld,
    kLimit,    // not held, and known to be so: why
    kLost,     // not held
    kRefused,  // by name: why
  };
  double mass = 0, step = 0;  // kg, s
  Outcome outcome = Outcome::kLost;
  HoldResult hold;
  std::string why;
};

/// Masses and steps of one world.
struct StabilityMap {
  std::string world;  // "PG70 on native", "sdh2"
  std::vector<double> masses, steps;
  std::vector<MapCell> cells;  // masses by steps

  int count(MapCell::Outcome outcome) const;
};

/// What is gripped, lifted and held, of 10 g to 10 kg, in steps of 0.1 to 10 ms; `quick`: fewer.
/// The PG70's World on each engine that is installed, the SDH-2 and the BarrettHand in RobotWorld.
/// `progress` is told of each map.
std::vector<StabilityMap> stability_maps(bool quick,
                                         const std::function<void(const std::string&)>& progress);

/// To be drawn.
report::CellMap cell_map(const StabilityMap& map);

}  // namespace prehend::eval::touch
