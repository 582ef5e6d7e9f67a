#include "prehend/control/cycle.h"

#include <algorithm>

namespace prehend::control {

std::string to_string(Phase phase) {
  switch (phase) {
    case Phase::kWaiting:
      return "waiting";
    case Phase::kApproach:
      return "approach";
    case Phase::kGrasp:
      return "grasp";
    case Phase::kLift:
      return "lift";
    case Phase::kMove:
      return "move";
    case Phase::kRelease:
      return "release";
    case Phase::kDone:
      return "done";
    case Phase::kFailed:
      return "failed";
  }
  return "unknown";
}

void Cycle::clear() {
  result_ = {};
  surprises_.clear();
  phase_times_.clear();
  failed_attempts_.clear();
  failure_.clear();
  grasp_index_ = 0;
  entered_ = now_;
}

void Cycle::advance_to(double time) {
  if (!phase_times_.empty()) phase_times_.back().second += std::max(0.0, time - now_);
  now_ = time;
}

void Cycle::entered(const std::string& detail) {
  detail_ = detail;
  entered_ = now_;
  const std::string name = to_string(phase());
  if (finished() || (!phase_times_.empty() && phase_times_.back().first == name)) return;
  phase_times_.emplace_back(name, 0.0);
}

void Cycle::begin_attempt(int grasp_index) {
  ++result_.attempts;
  result_.grasp_index = grasp_index_ = grasp_index;
  failure_.clear();
  attempts_surprises_ = surprises_.size();
}

void Cycle::add_surprise(SurpriseKind kind, double predicted, double felt,
                         const std::string& reaction) {
  surprises_.push_back(compare(kind, predicted, felt, tolerances_, reaction));
}

void Cycle::fail_attempt(int step, const std::string& reason, SurpriseKind kind,
                         const std::string& reaction) {
  failure_ = reason;
  failed_attempts_.add(step, reason);
  const bool surprised =
      std::any_of(surprises_.begin() + static_cast<std::ptrdiff_t>(attempts_surprises_),
                  surprises_.end(), [](const Surprise& surprise) { return surprise.surprising; });
  if (!surprised) add_surprise(kind, 1, 0, reaction);
}

}  // namespace prehend::control
