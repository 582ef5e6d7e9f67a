#include "nodes/report/verdict.h"

#include <algorithm>

#include <fmt/format.h>

#include "prehend/grasp/uncertainty.h"

namespace prehend::nodes {
namespace {

constexpr double kRequiredRaise = 0.1;   // m
constexpr double kRequiredMove = 0.03;   // m
constexpr double kPutDownHeight = 0.01;  // m, over the table

// The reason of the stage at which the chain broke, from the end to the beginning.
std::string missing_stage(const Collected& collected) {
  if (!collected.objects) return "no object hypotheses came";
  if (!collected.objects->problem().empty()) return collected.objects->problem();
  if (collected.objects->objects().empty()) return "no objects were found";
  if (collected.shapes.empty()) return "no completed shape came";
  if (collected.models.empty()) return "no object model came";
  if (collected.plans.empty()) return "no grasp plan came";
  return collected.phases.empty() ? "the grasp cycle did not start"
                                  : "the grasp cycle stayed in " + collected.phases.back().second;
}

}  // namespace

Lift measure_lift(const Collected& collected) {
  Lift best;
  for (const auto& [name, body] : collected.bodies) {
    if (body.height.empty()) continue;
    const double first = body.height.front().second;
    double highest = first;
    for (const auto& [time, height] : body.height) highest = std::max(highest, height);
    if (highest - first <= best.raised) continue;
    best = {name, highest - first, body.horizontal.back().second, body.height.back().second};
  }
  return best;
}

const msgs::Grasp* executed_grasp(const Collected& collected) {
  if (!collected.result || collected.result->attempts() == 0) return nullptr;
  const auto plan = collected.plans.find(collected.result->object_id());
  const auto index = static_cast<int>(collected.result->grasp_index());
  if (plan == collected.plans.end() || index >= plan->second.grasps_size()) return nullptr;
  return &plan->second.grasps(index);
}

std::string trust_text(const msgs::Grasp& grasp) {
  // The remark of a grasp that was planned beside better ones may say already that it was not
  // tried.
  const bool says_so = grasp.remark().find(grasp::kNotAssessed) != std::string::npos;
  std::string text;
  if (grasp.has_robustness()) {
    text = fmt::format("held in {:.0f} % of the disturbed trials", 100 * grasp.robustness());
  } else if (!says_so) {
    text = grasp::kNotAssessed;
  }
  if (!grasp.remark().empty()) text += (text.empty() ? "" : "; ") + grasp.remark();
  return text;
}

std::optional<std::string> why_not_graspable(const std::string& problem) {
  static const std::string kStart = "cannot be grasped: ";
  if (!problem.starts_with(kStart)) return std::nullopt;
  return problem.substr(kStart.size());
}

Verdict judge(const Collected& collected, const std::string& timeout_reason) {
  Verdict verdict;
  if (!collected.result) {
    const std::string reason = missing_stage(collected);
    verdict.text = timeout_reason.empty() ? reason : timeout_reason + ": " + reason;
    return verdict;
  }
  const auto& result = *collected.result;
  if (!result.success()) {
    verdict.text = result.reason();
    if (const auto why = why_not_graspable(result.reason()); why && result.attempts() == 0) {
      verdict = {Verdict::Kind::kNotGraspable, *why};
    }
    return verdict;
  }
  const Lift lift = measure_lift(collected);
  verdict.kind = Verdict::Kind::kSuccess;
  if (collected.bodies.empty()) {  // real hardware: only the cycle's own word
    verdict.text = result.reason();
    return verdict;
  }
  std::string measured = fmt::format(
      "'{}' was raised by {:.0f} mm, moved by {:.0f} mm and ended {:.1f} mm over the table",
      lift.body, 1000 * lift.raised, 1000 * lift.moved, std::max(0.0, 1000 * lift.end_height));
  if (collected.on_prediction) measured += ", executed on the predicted mesh";
  if (lift.raised < kRequiredRaise) {
    verdict.kind = Verdict::Kind::kFailure;
    verdict.text = lift.body.empty() ? "the cycle says it succeeded, but nothing was raised"
                                     : "the cycle says it succeeded, but " + measured;
  } else if (lift.moved < kRequiredMove || lift.end_height > kPutDownHeight) {
    verdict.kind = Verdict::Kind::kFailure;
    verdict.text = "the object was lifted but not moved and put down: " + measured;
  } else {
    verdict.text = measured;
    if (const auto* grasp = executed_grasp(collected))
      verdict.text += ". The grasp: " + trust_text(*grasp);
  }
  return verdict;
}

}  // namespace prehend::nodes
