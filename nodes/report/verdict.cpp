#include "nodes/report/verdict.h"

#include <algorithm>

#include <fmt/format.h>

#include "msgs/convert/outcomes.h"
#include "prehend/geometry/errors.h"
#include "prehend/grasp/uncertainty.h"

namespace prehend::nodes {
namespace {

constexpr double kRequiredRaise = 0.1;   // m
constexpr double kRequiredMove = 0.03;   // m
constexpr double kPutDownHeight = 0.01;  // m, over the table

// Whether the task, as far as it was gone through, puts objects elsewhere.
bool places_objects(const Collected& collected) {
  if (!collected.task) return true;
  const auto& path = collected.result->task_path();
  return std::any_of(collected.task->states().begin(), collected.task->states().end(),
                     [&path](const auto& state) {
                       return state.action() == msgs::Task::PLACE &&
                              std::count(path.begin(), path.end(), state.name()) > 0;
                     });
}

// The reason of the stage at which the chain broke, from the end to the beginning.
std::string missing_stage(const Collected& collected) {
  if (!collected.objects) return "no object hypotheses came";
  if (!collected.objects->problem().empty()) return collected.objects->problem();
  if (collected.objects->objects().empty()) return "no objects were found";
  if (collected.shapes.empty()) return "no completed shape came";
  if (collected.models.empty()) return "no object model came";
  if (collected.plans.empty()) return "no grasp plan came";
  return collected.phases.empty()
             ? "the grasp cycle did not start"
             : "the grasp cycle stayed in " + to_string(collected.phases.back().second);
}

}  // namespace

std::vector<Lift> measure_lifts(const Collected& collected) {
  std::vector<Lift> lifts;
  for (const auto& [name, body] : collected.bodies) {
    if (body.height.empty()) continue;
    const double first = body.height.front().second;
    double highest = first;
    for (const auto& [time, height] : body.height) highest = std::max(highest, height);
    if (highest <= first) continue;
    lifts.push_back(
        {name, highest - first, body.horizontal.back().second, body.height.back().second});
  }
  std::stable_sort(lifts.begin(), lifts.end(),
                   [](const Lift& a, const Lift& b) { return a.raised > b.raised; });
  return lifts;
}

const msgs::Grasp* executed_grasp(const Collected& collected) {
  if (!collected.result || collected.result->attempts() == 0) return nullptr;
  const auto plan = collected.plans.find(collected.result->object_id());
  const auto index = static_cast<int>(collected.result->grasp_index());
  if (plan == collected.plans.end() || index >= plan->second.grasps_size()) return nullptr;
  return &plan->second.grasps(index);
}

std::string trust_text(const msgs::Grasp& grasp) {
  const std::string text =
      grasp.has_robustness()
          ? fmt::format("held in {:.0f} % of the disturbed trials", 100 * grasp.robustness())
          : grasp::kNotAssessed;
  return grasp.remark().empty() ? text : text + "; " + grasp.remark();
}

Verdict judge(const Collected& collected, const std::string& timeout_reason) {
  Verdict verdict;
  if (!collected.result) {
    const std::string reason = missing_stage(collected);
    verdict.text = timeout_reason.empty() ? reason : timeout_reason + ": " + reason;
    return verdict;
  }
  const auto& result = *collected.result;
  try {
    switch (convert::from_message(result.outcome())) {
      case control::CycleOutcome::kSucceeded:
        break;
      case control::CycleOutcome::kUngraspable:
        return {Verdict::Kind::kNotGraspable, result.reason()};
      case control::CycleOutcome::kFailed:
        return {Verdict::Kind::kFailure, result.reason()};
    }
  } catch (const geometry::InputError& error) {
    return {Verdict::Kind::kFailure, error.what()};
  }
  const std::vector<Lift> lifts = measure_lifts(collected);
  const Lift lift = lifts.empty() ? Lift{} : lifts.front();
  const bool places = places_objects(collected);
  verdict.kind = Verdict::Kind::kSuccess;
  if (collected.bodies.empty()) {  // real hardware: only the cycle's own word
    verdict.text = result.reason();
    return verdict;
  }
  std::string measured = fmt::format(
      "'{}' was raised by {:.0f} mm, moved by {:.0f} mm and ended {:.1f} mm over the table",
      lift.body, 1000 * lift.raised, 1000 * lift.moved, std::max(0.0, 1000 * lift.end_height));
  if (collected.on_prediction) measured += ", executed on the predicted mesh";
  const auto is_put_down = [places](const Lift& one) {
    return one.raised >= kRequiredRaise && one.end_height <= kPutDownHeight &&
           (!places || one.moved >= kRequiredMove);
  };
  const auto put_down = std::count_if(lifts.begin(), lifts.end(), is_put_down);
  if (result.attempts() == 0) {
    verdict.text = result.reason();  // nothing was left to do
  } else if (lift.raised < kRequiredRaise) {
    verdict.kind = Verdict::Kind::kFailure;
    verdict.text = lift.body.empty() ? "the cycle says it succeeded, but nothing was raised"
                                     : "the cycle says it succeeded, but " + measured;
  } else if (!is_put_down(lift)) {
    verdict.kind = Verdict::Kind::kFailure;
    verdict.text = std::string("the object was lifted but not ") + (places ? "moved and " : "") +
                   "put down: " + measured;
  } else {
    verdict.text = measured;
    if (put_down > 1) verdict.text = fmt::format("{} objects were moved and put down: ", put_down);
    for (std::size_t i = 0; put_down > 1 && i < lifts.size(); ++i) {
      if (!is_put_down(lifts[i])) continue;
      verdict.text += fmt::format("{}'{}' by {:.0f} mm", i == 0 ? "" : ", ", lifts[i].body,
                                  1000 * lifts[i].moved);
    }
    if (const auto* grasp = executed_grasp(collected))
      verdict.text += ". The grasp: " + trust_text(*grasp);
  }
  return verdict;
}

}  // namespace prehend::nodes
