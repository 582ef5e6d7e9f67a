#pragma once

#include <string>

#include "prehend/contact/grasp_stepper.h"
#include "prehend/contact/pad_grid.h"
#include "prehend/fidelity/front.h"

namespace prehend::fidelity {

/// How soft pads are simulated.
struct TouchOptions {
  contact::StepOptions step;
  contact::SolveOptions solve;
  contact::PadGrid pad;
};

/// The options of a setting of the front "touch". Knobs (all optional; absent: the library's
/// default):
///   integration   explicit | first_order | second_order | adaptive
///   step          s, above 0
///   tolerance     m, above 0; of adaptive steps
///   iterations    at most so many linearisations a step, 1 to 100
///   rows, columns of texels on a pad of unchanged size and stiffness, 1 to 1000
/// @throws geometry::InputError naming a knob that is unknown or has a value it cannot have.
TouchOptions touch_options(const Setting& setting);

/// A physics engine, by what simulation::engines::EngineScene calls it.
struct EngineChoice {
  std::string engine = "native", solver;
  bool pads = true;    // otherwise rigid plates
  double step = 1e-3;  // s
};

/// The choice of a setting of the front "touch_engines". Knobs: engine, solver, pads (yes | no),
/// step [s]. @throws as touch_options.
EngineChoice engine_choice(const Setting& setting);

}  // namespace prehend::fidelity
