#include "nodes/report/verdict.h"

#include <algorithm>

#include <fmt/format.h>

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

Verdict judge(const Collected& collected, bool require_lift, const std::string& timeout_reason) {
  Verdict verdict;
  if (!collected.result) {
    const std::string reason = missing_stage(collected);
    verdict.text = timeout_reason.empty() ? reason : timeout_reason + ": " + reason;
    return verdict;
  }
  const auto& result = *collected.result;
  if (!result.success()) {
    verdict.ungraspable = result.reason().rfind("cannot be grasped", 0) == 0;
    verdict.success = verdict.ungraspable && !require_lift;
    verdict.text = result.reason();
    return verdict;
  }
  const Lift lift = measure_lift(collected);
  verdict.success = true;
  if (collected.bodies.empty()) {  // real hardware: only the cycle's own word
    verdict.text = result.reason();
    return verdict;
  }
  const std::string measured = fmt::format(
      "'{}' was raised by {:.0f} mm, moved by {:.0f} mm and ended {:.1f} mm over the table",
      lift.body, 1000 * lift.raised, 1000 * lift.moved, std::max(0.0, 1000 * lift.end_height));
  if (lift.raised < kRequiredRaise) {
    verdict.success = false;
    verdict.text = lift.body.empty() ? "the cycle says it succeeded, but nothing was raised"
                                     : "the cycle says it succeeded, but " + measured;
  } else if (lift.moved < kRequiredMove || lift.end_height > kPutDownHeight) {
    verdict.success = false;
    verdict.text = "the object was lifted but not moved and put down: " + measured;
  } else {
    verdict.text = measured;
  }
  return verdict;
}

}  // namespace prehend::nodes
