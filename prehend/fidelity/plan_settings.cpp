#include "prehend/fidelity/plan_settings.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "prehend/fidelity/chain_settings.h"
#include "prehend/fidelity/knobs.h"
#include "prehend/geometry/errors.h"
#include "prehend/grasp/generators/generator_registry.h"

namespace prehend::fidelity {
namespace {

constexpr const char* kPlanSubject = "plan";
constexpr double kLeastBudget = 0.01;  // s, in which some candidates are tried
constexpr double kOffset = 0.015;      // m, between positions across the fingers

int whole_number(const std::string& knob, const std::string& text, int least) {
  const int value = knob_number<int>(kPlanSubject, knob, text);
  if (value < least) refuse_knob(kPlanSubject, knob, text);
  return value;
}

std::vector<std::string> generators_of(const std::string& knob, const std::string& text) {
  const grasp::GeneratorRegistry known;
  std::vector<std::string> names;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find('+', start), text.size());
    names.push_back(text.substr(start, end - start));
    if (!known.has(names.back())) refuse_knob(kPlanSubject, knob, text);
    start = end + 1;
  }
  return names;
}

// 0, -15 mm, 15 mm, -30 mm, ...
std::vector<double> offsets_of(const std::string& text) {
  const int count = whole_number("offsets", text, 1);
  if (count % 2 == 0) refuse_knob(kPlanSubject, "offsets", text);
  std::vector<double> offsets{0};
  for (int i = 1; i <= count / 2; ++i) {
    offsets.push_back(-i * kOffset);
    offsets.push_back(i * kOffset);
  }
  return offsets;
}

}  // namespace

void apply_plan_setting(const Setting& setting, grasp::PlannerOptions* options) {
  for (const auto& [knob, value] : setting.knobs) {
    if (knob == "generators") {
      options->generators = generators_of(knob, value);
    } else if (knob == "further") {
      options->further_generators.clear();
      if (value != "none") options->further_generators = generators_of(knob, value);
    } else if (knob == "rolls") {
      options->candidates.circles.rolls = whole_number(knob, value, 1);
    } else if (knob == "standoffs") {
      options->candidates.circles.standoffs = whole_number(knob, value, 1);
    } else if (knob == "offsets") {
      options->candidates.circles.lateral_offsets = offsets_of(value);
    } else if (knob == "samples") {
      options->uncertainty.samples = whole_number(knob, value, 0);
    } else if (knob == "count") {
      options->largest_count = whole_number(knob, value, 1);
    } else if (knob == "enough") {
      options->enough_grasps = whole_number(knob, value, 0);
    } else if (knob == "first_share") {
      options->first_share = whole_number(knob, value, 1);
    } else {
      unknown_knob(kPlanSubject, knob);
    }
  }
}

ChosenPlan apply_plan_front(const Front& front, double budget, double tolerance,
                            grasp::PlannerOptions* options) {
  if (tolerance > 0 && front.subject == kPlanSubject) {
    throw geometry::InputError("A tolerance is of meshes, of which the front 'plan' says nothing",
                               "Give a budget, or the front of the chain");
  }
  Setting chosen;
  std::string note;
  try {
    chosen = choose_for_stage(front, budget, tolerance);
  } catch (const UnreachableError& error) {
    if (!(budget > 0)) throw;
    chosen = error.nearest();
    note = "; none is as fast as asked for, planning is cut off";
  }
  const Setting own = stage_setting(front, chosen, Stage::kPlan);
  apply_plan_setting(own, options);
  if (budget > 0) {
    const double before =
        front.subject == kPlanSubject ? 0 : chosen.seconds - stage_seconds(chosen, Stage::kPlan);
    options->budget = std::max(kLeastBudget, budget - before);
  }
  return {chosen, fmt::format("{} ({}{})", to_string(own), measured_text(front, chosen), note)};
}

}  // namespace prehend::fidelity
