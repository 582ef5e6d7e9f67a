#include "prehend/fidelity/touch_settings.h"

#include "prehend/fidelity/knobs.h"

namespace prehend::fidelity {
namespace {

constexpr const char* kTouchSubject = "touch";

double positive(const std::string& knob, const std::string& value) {
  const auto number = knob_number<double>(kTouchSubject, knob, value);
  if (!(number > 0 && number < 1)) refuse_knob(kTouchSubject, knob, value);
  return number;
}

int count(const std::string& knob, const std::string& value, int most) {
  const int number = knob_number<int>(kTouchSubject, knob, value);
  if (number < 1 || number > most) refuse_knob(kTouchSubject, knob, value);
  return number;
}

}  // namespace

void apply_touch_setting(const Setting& setting, simulation::Scene* scene) {
  simulation::PhysicsOptions& physics = scene->physics;
  for (const auto& [knob, value] : setting.knobs) {
    if (knob == "integration") {
      physics.adaptive = value == "adaptive";
      if (value == "first_order") {
        physics.integration = contact::Integration::kFirstOrder;
      } else if (value == "second_order") {
        physics.integration = contact::Integration::kSecondOrder;
      } else if (!physics.adaptive) {
        refuse_knob(kTouchSubject, knob, value);
      }
    } else if (knob == "step") {
      scene->step = positive(knob, value);
    } else if (knob == "tolerance") {
      physics.tolerance = positive(knob, value);
    } else if (knob == "iterations") {
      physics.most_iterations = count(knob, value, 100);
    } else {
      unknown_knob(kTouchSubject, knob);
    }
  }
}

double touch_hand_step(const Setting& setting) {
  double step = 0;
  for (const auto& [knob, value] : setting.knobs) {
    if (knob != "step") unknown_knob(kTouchSubject, knob);
    step = positive(knob, value);
  }
  if (step == 0) refuse_knob(kTouchSubject, "step", "");
  return step;
}

EngineChoice engine_choice(const Setting& setting) {
  EngineChoice choice;
  for (const auto& [knob, value] : setting.knobs) {
    if (knob == "engine") {
      choice.engine = value;
    } else if (knob == "solver") {
      choice.solver = value;
    } else if (knob == "pads") {
      choice.pads = knob_is(kTouchSubject, knob, value, "yes", "no");
    } else if (knob == "step") {
      choice.step = positive(knob, value);
    } else {
      unknown_knob(kTouchSubject, knob);
    }
  }
  if (choice.engine.empty()) refuse_knob(kTouchSubject, "engine", "");
  return choice;
}

}  // namespace prehend::fidelity
