#include "prehend/control/failed_attempts.h"

#include <algorithm>

namespace prehend::control {

std::string FailedAttempts::text() const {
  const std::size_t count = attempts_.size();
  if (count == 0) return "no grasp was tried";
  const auto furthest =
      std::max_element(attempts_.begin(), attempts_.end(),
                       [](const Attempt& a, const Attempt& b) { return a.progress < b.progress; });
  std::string text =
      "no grasp succeeded in " + std::to_string(count) + (count == 1 ? " attempt" : " attempts");
  if (furthest->progress > attempts_.back().progress) {
    text += "; attempt " + std::to_string(furthest - attempts_.begin() + 1) +
            " came furthest: " + furthest->reason;
  }
  return text + "; the last: " + attempts_.back().reason;
}

}  // namespace prehend::control
