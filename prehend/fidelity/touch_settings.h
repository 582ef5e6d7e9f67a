#pragma once

#include <string>

#include "prehend/fidelity/front.h"
#include "prehend/simulation/scene.h"

namespace prehend::fidelity {

/// Sets how `scene` is simulated as a setting of the front "touch" chooses it; all else stays. What
/// pads show keeps its rows and columns: they are the pad's, no knob. Knobs (all optional; absent:
/// as it is):
///   integration   first_order | second_order | adaptive
///   step          s, above 0 and below 1
///   tolerance     m, the same; of adaptive steps
///   iterations    at most so many linearisations a step, 1 to 100
/// @throws geometry::InputError naming a knob that is unknown or has a value it cannot have.
void apply_touch_setting(const Setting& setting, simulation::Scene* scene);

/// The step [s] of a setting of the front "touch_hand", which has this one knob: robots of arm and
/// hand, and hands alone (simulation::RobotWorld). @throws as apply_touch_setting, and without it.
double touch_hand_step(const Setting& setting);

/// A physics engine, by what simulation::engines::EngineScene calls it.
struct EngineChoice {
  std::string engine = "native", solver;
  bool pads = true;    // otherwise rigid plates
  double step = 1e-3;  // s
};

/// The choice of a setting of the front "touch_engines". Knobs: engine, solver, pads (yes | no),
/// step [s]. @throws as apply_touch_setting.
EngineChoice engine_choice(const Setting& setting);

}  // namespace prehend::fidelity
