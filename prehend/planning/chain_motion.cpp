#include "prehend/planning/chain_motion.h"

#include <string>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/knobs.h"

namespace prehend::planning {
namespace {

constexpr const char* kSubject = "motion";

void set_simulation(const std::string& step, PlatformPlanOptions* options) {
  if (step == "none") {
    options->touch.reset();
    return;
  }
  const auto seconds = fidelity::knob_number<double>(kSubject, "step", step);
  if (!(seconds > 0 && seconds < 1)) fidelity::refuse_knob(kSubject, "step", step);
  if (options->touch) options->touch->world.step = seconds;
}

}  // namespace

void apply_motion_setting(const fidelity::Front& front, const fidelity::Setting& setting,
                          PlatformPlanOptions* options) {
  if (front.subject == to_string(fidelity::Stage::kPlan)) return;
  for (const auto& [knob, value] : stage_setting(front, setting, fidelity::Stage::kMotion).knobs) {
    if (knob != "grasps") fidelity::unknown_knob(kSubject, knob);
    options->motions = fidelity::knob_number<int>(kSubject, knob, value);
    if (options->motions < 1) fidelity::refuse_knob(kSubject, knob, value);
  }
  for (const auto& [knob, value] :
       stage_setting(front, setting, fidelity::Stage::kSimulation).knobs) {
    if (knob != "step") fidelity::unknown_knob(kSubject, knob);
    set_simulation(value, options);
  }
}

}  // namespace prehend::planning
