#include "prehend/fidelity/plan_settings.h"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>

#include "prehend/fidelity/knobs.h"
#include "prehend/grasp/generators/generator_registry.h"

namespace prehend::fidelity {
namespace {

constexpr const char* kPlanSubject = "plan";
constexpr double kOffset = 0.015;  // m, between positions across the fingers

int whole_number(const std::string& knob, const std::string& text, int least) {
  const int value = knob_number<int>(kPlanSubject, knob, text);
  if (value < least) refuse_knob(kPlanSubject, knob, text);
  return value;
}

std::vector<std::string> generators_of(const std::string& text) {
  const grasp::GeneratorRegistry known;
  std::vector<std::string> names;
  for (std::size_t start = 0; start <= text.size();) {
    const std::size_t end = std::min(text.find('+', start), text.size());
    names.push_back(text.substr(start, end - start));
    if (!known.has(names.back())) refuse_knob(kPlanSubject, "generators", text);
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
      options->generators = generators_of(value);
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
    } else {
      unknown_knob(kPlanSubject, knob);
    }
  }
}

std::string apply_plan_budget(const Front& front, double seconds, grasp::PlannerOptions* options) {
  Setting chosen;
  std::string note;
  try {
    chosen = within_budget(front, seconds);
  } catch (const UnreachableError& error) {
    chosen = error.nearest();
    note = "; none is as fast as asked for, planning is cut off";
  }
  apply_plan_setting(chosen, options);
  options->budget = seconds;
  return fmt::format("{} ({:.0f} ms, {:.0f} % not lifted at the first attempt{})",
                     to_string(chosen), 1e3 * chosen.seconds, 100 * chosen.error, note);
}

}  // namespace prehend::fidelity
