#pragma once

#include <functional>
#include <string>
#include <vector>

#include "eval/data_sets.h"
#include "prehend/fidelity/front.h"

namespace prehend::eval {

/// One setting of the planner of the PG70 on its stage, on some views.
struct MeasuredPlan {
  /// Mean time of planning the hand's grasps; share of views not lifted at the first attempt.
  fidelity::Setting setting;
  int first = 0;  // views lifted at the first attempt
  int within_three = 0;
  int views = 0;
};

/// From few candidates to many, of one way and of several, with and without robustness; `quick`
/// takes every fourth.
std::vector<fidelity::Setting> swept_plan_settings(bool quick);

/// The views of a sweep: of eight objects that fit the PG70 (the last one scanned, left out where
/// it is not among the sets), two opposite orientations each; one with `quick`. Always the same.
std::vector<Case> views_to_sweep(const std::vector<DataSet>& sets, bool quick);

/// Plans on the prediction of each view by each setting and executes on the truth, as eval_grasp
/// does; processor time of planning. `progress` is told what is at
/// hand. Views whose object is not seen count as failures of all.
std::vector<MeasuredPlan> measure_plan_tradeoff(
    const std::vector<Case>& cases, const std::vector<fidelity::Setting>& settings,
    const std::function<void(const std::string&)>& progress);

/// Its error is the share of views that were not lifted at the first attempt.
fidelity::Front plan_front(const std::vector<MeasuredPlan>& measured, const std::string& machine);

}  // namespace prehend::eval
