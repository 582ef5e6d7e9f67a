#pragma once

#include <functional>
#include <string>
#include <vector>

#include "prehend/fidelity/front.h"

namespace prehend::eval::touch {

/// Speed against error of soft pads, the error being consistency: the distance to a finer run of
/// the same scene, after Erez, Tassa and Todorov, "Simulation Tools for Model-Based Robotics:
/// Comparison of Bullet, Havok, MuJoCo, ODE and PhysX" (ICRA 2015).
struct TouchTradeoff {
  /// Work cycles of boxes of 0.1, 0.3 and 1 kg that cover 52, 60 and 100 % of the pads. seconds: of
  /// processor for each simulated second; error: the largest distance [m] of the box from where
  /// SDIRK2 with the reference's steps and 6 x 14 texels has it, at any tenth of a second; a box
  /// that is lost counts with how far it is then.
  std::vector<fidelity::Setting> cycle;
  /// The cube of the hold test pressed, loaded and shaken (see shaken_hold): all engines.
  std::vector<fidelity::Setting> engines;
  std::vector<std::string> left_out;  // settings without a finite result, and why
};

constexpr double kReferenceStep = 1e-4;  // s

/// Settings of the work cycle: order, step, tolerance, iterations, texels; `quick` takes a few.
std::vector<fidelity::Setting> swept_cycle_settings(bool quick);
/// Every installed engine and solver, with pads and as rigid plates, with several steps.
std::vector<fidelity::Setting> swept_engine_settings(bool quick);

/// Measures settings (only knobs are read); time is the least of `repetitions`. `progress` is told
/// of each.
TouchTradeoff measure_touch_tradeoff(const std::vector<fidelity::Setting>& cycle,
                                     const std::vector<fidelity::Setting>& engines, int repetitions,
                                     const std::function<void(const std::string&)>& progress,
                                     double reference_step = kReferenceStep);

/// Fronts "touch" and "touch_engines", of settings that lose nothing: less than 5 mm off.
fidelity::Front cycle_front(const TouchTradeoff& tradeoff, const std::string& machine);
fidelity::Front engine_front(const TouchTradeoff& tradeoff, const std::string& machine);

}  // namespace prehend::eval::touch
