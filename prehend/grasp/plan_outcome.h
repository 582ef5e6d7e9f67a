#pragma once

#include <string>

namespace prehend::grasp {

/// What became of planning on an object.
enum class PlanOutcome {
  kFailed,       // it could not be planned on: nobody knows whether it can be grasped
  kUngraspable,  // an answer: no grasp of it can be executed
  kGraspable,
};

/// "failed".
constexpr const char* to_string(PlanOutcome outcome) {
  switch (outcome) {
    case PlanOutcome::kFailed:
      return "failed";
    case PlanOutcome::kUngraspable:
      return "ungraspable";
    case PlanOutcome::kGraspable:
      return "graspable";
  }
  return "unknown";
}

/// What planning says of an object.
struct PlanAnswer {
  PlanOutcome outcome = PlanOutcome::kFailed;
  std::string problem;  // why there is no grasp, in words; empty: there is one
};

/// "cannot be grasped: " and why.
inline std::string ungraspable_text(const std::string& why) { return "cannot be grasped: " + why; }

/// What to tell people of an object without a grasp.
inline std::string in_words(const PlanAnswer& answer) {
  return answer.outcome == PlanOutcome::kUngraspable ? ungraspable_text(answer.problem)
                                                     : answer.problem;
}

}  // namespace prehend::grasp
