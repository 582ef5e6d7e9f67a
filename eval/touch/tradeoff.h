#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "eval/touch/felt.h"
#include "prehend/fidelity/front.h"

namespace prehend::eval::touch {

/// A setting, its time (setting.seconds: of processor for each simulated second) and its errors,
/// the worst of the scenes.
struct MeasuredTouch {
  fidelity::Setting setting;
  bool feels = true;  // false: rigid plates, of which only FeltError::motion counts
  FeltError error;    // from the reference
  /// Of engines: from a run of the same engine, solver and pads with steps of its own that are
  /// finer.
  std::optional<FeltError> own;
};

/// Speed against error of soft pads, the error being consistency: the distance to a finer run of
/// the same scene, after Erez, Tassa and Todorov, "Simulation Tools for Model-Based Robotics:
/// Comparison of Bullet, Havok, MuJoCo, ODE and PhysX" (ICRA 2015), of what is felt and of motion
/// (FeltError).
struct TouchTradeoff {
  /// run_gripper_cycle of all objects; reference: second order with the reference's steps.
  std::vector<MeasuredTouch> cycle;
  /// The same with other texels on pads of that size (knobs rows, columns), from that reference
  /// with 14 x 6. No choice: see touch_settings.h.
  std::vector<MeasuredTouch> texels;
  /// run_hand_cycle of the SDH-2 with 0.1, 0.3 and 1 kg; reference: the reference's steps.
  std::vector<MeasuredTouch> hand;
  /// The cube of the hold test pressed, loaded and shaken (see shaken_hold), of 0.1, 0.3 and 1 kg:
  /// all engines; reference: native, second order, with the reference's steps and pads.
  std::vector<MeasuredTouch> engines;
  std::vector<std::string> left_out;  // settings without a finite result, and why
};

/// What is measured. Of the settings only knobs are read.
struct TouchSweep {
  std::vector<fidelity::Setting> cycle, texels, hand, engines;
  int repetitions = 3;            // the time is the least of them
  double reference_step = 2e-5;   // s
  double own_finest_step = 1e-5;  // s, of each engine's own reference
};

/// Order, step, tolerance, iterations; texels; steps of hands; every installed engine and solver
/// with pads and as rigid plates, with several steps. `quick`: a few of each.
TouchSweep touch_sweep(bool quick);

/// `progress` is told of each setting.
TouchTradeoff measure_touch_tradeoff(const TouchSweep& sweep,
                                     const std::function<void(const std::string&)>& progress);

/// Fronts "touch", "touch_hand" and "touch_engines", by FeltError::image, of settings that feel and
/// lose nothing: less than 5 mm off.
fidelity::Front cycle_front(const TouchTradeoff& tradeoff, const std::string& machine);
fidelity::Front hand_front(const TouchTradeoff& tradeoff, const std::string& machine);
fidelity::Front engine_front(const TouchTradeoff& tradeoff, const std::string& machine);

}  // namespace prehend::eval::touch
