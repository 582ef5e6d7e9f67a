#include "eval/grasp/plan_tradeoff.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>

#include "eval/grasp/grasp_trials.h"
#include "eval/grasp/platform_under_test.h"
#include "prehend/fidelity/plan_settings.h"
#include "prehend/text/tree_file.h"

namespace prehend::eval {
namespace {

using fidelity::Setting;

// What fits between the fingers in the resting pose, of different kinds.
constexpr std::array<std::string_view, 8> kObjects{"bottle",      "spray_bottle",       "cone",
                                                   "milk_carton", "spray_bottle_lying", "toy",
                                                   "cereal_box",  "mustard_bottle"};

}  // namespace

std::vector<Setting> swept_plan_settings(bool quick) {
  std::vector<Setting> settings;
  const auto add = [&](const char* generators, const char* rolls, const char* standoffs,
                       const char* offsets, const char* samples) {
    settings.push_back({{{"generators", generators},
                         {"rolls", rolls},
                         {"standoffs", standoffs},
                         {"offsets", offsets},
                         {"samples", samples}},
                        0,
                        0});
  };
  add("circles", "6", "3", "1", "0");
  add("circles", "6", "3", "1", "16");
  add("circles", "12", "4", "1", "8");
  add("circles", "12", "6", "3", "0");
  add("circles", "12", "6", "3", "4");
  add("circles", "12", "6", "3", "16");
  add("circles+boxes", "12", "6", "3", "8");
  add("circles+boxes", "12", "6", "3", "16");
  add("circles+boxes+antipodal", "12", "6", "3", "16");
  add("circles+boxes+antipodal", "24", "8", "5", "32");
  if (!quick) return settings;
  std::vector<Setting> few;
  for (std::size_t i = 0; i < settings.size(); i += 4) few.push_back(settings[i]);
  return few;
}

std::vector<Case> views_to_sweep(const std::vector<DataSet>& sets, bool quick) {
  std::vector<Case> cases;
  int index = 0;
  for (const DataSet& set : sets) {
    if (std::find(kObjects.begin(), kObjects.end(), set.name) == kObjects.end()) continue;
    // Opposite sides, from another orientation for each object.
    const int first = 45 * (3 * index + 1) % 360;
    cases.push_back({&set, first, 1});
    if (!quick) cases.push_back({&set, (first + 180) % 360, 1});
    ++index;
  }
  return cases;
}

std::vector<MeasuredPlan> measure_plan_tradeoff(
    const std::vector<Case>& cases, const std::vector<Setting>& settings,
    const std::function<void(const std::string&)>& progress) {
  std::vector<MeasuredPlan> measured;
  std::vector<PlannerSetting> planners;
  for (const Setting& setting : settings) {
    measured.push_back({setting, 0, 0, static_cast<int>(cases.size())});
    measured.back().setting.seconds = 0;
    PlannerSetting& planner = planners.emplace_back();
    planner.name = fidelity::to_string(setting);
    planner.change = [setting](planning::PlatformPlanOptions* options) {
      fidelity::apply_plan_setting(setting, &options->grasps);
    };
  }
  const PlatformUnderTest stage(text::tree_file("config/robots/stage_pg70.yaml"));
  for (const Case& one : cases) {
    progress(one.name());
    const GraspCase result = run_grasp_case(one, stage, planners);
    for (std::size_t i = 0; i < measured.size(); ++i) {
      const GraspTrial& trial = result.trials[i];
      measured[i].first += trial.lifted_at_first();
      measured[i].within_three += trial.lifted;
      if (trial.candidates > 0) measured[i].setting.seconds += trial.grasp_seconds;
    }
  }
  for (MeasuredPlan& m : measured) {
    m.setting.seconds /= m.views;
    m.setting.error = static_cast<double>(m.views - m.first) / m.views;
    progress(fmt::format("{:.0f} ms, {} of {} at first, {} within three: {}",
                         1e3 * m.setting.seconds, m.first, m.views, m.within_three,
                         fidelity::to_string(m.setting)));
  }
  return measured;
}

fidelity::Front plan_front(const std::vector<MeasuredPlan>& measured, const std::string& machine) {
  std::vector<Setting> settings;
  for (const MeasuredPlan& m : measured) settings.push_back(m.setting);
  fidelity::Front front;
  front.subject = "plan";
  front.error_name = "share of views not lifted at the first attempt";
  front.error_unit = "of views";
  front.machine = machine;
  front.settings = fidelity::pareto_front(std::move(settings));
  return front;
}

}  // namespace prehend::eval
