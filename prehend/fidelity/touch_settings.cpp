#include "prehend/fidelity/touch_settings.h"

#include <stdexcept>

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

TouchOptions touch_options(const Setting& setting) {
  TouchOptions options;
  for (const auto& [knob, value] : setting.knobs) {
    if (knob == "integration") {
      try {
        options.step.integration = contact::integration_from_name(value);
      } catch (const std::invalid_argument&) {
        refuse_knob(kTouchSubject, knob, value);
      }
    } else if (knob == "step") {
      options.step.step = positive(knob, value);
    } else if (knob == "tolerance") {
      options.step.tolerance = positive(knob, value);
    } else if (knob == "iterations") {
      options.solve.most_iterations = count(knob, value, 100);
    } else if (knob == "rows") {
      options.pad.rows = count(knob, value, 1000);
    } else if (knob == "columns") {
      options.pad.columns = count(knob, value, 1000);
    } else {
      unknown_knob(kTouchSubject, knob);
    }
  }
  return options;
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
