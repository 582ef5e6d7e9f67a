#include "prehend/sweep/handout.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace prehend::sweep {

Handout::Handout(std::vector<OpenCase> open) : open_(std::move(open)) {
  const auto length = [](const OpenCase& one) {
    return one.seconds.value_or(std::numeric_limits<double>::infinity());
  };
  std::sort(open_.begin(), open_.end(), [&](const OpenCase& a, const OpenCase& b) {
    return length(a) != length(b) ? length(a) > length(b) : a.index < b.index;
  });
}

std::optional<std::int64_t> Handout::next() {
  if (!again_.empty()) {
    const std::int64_t index = again_.front();
    again_.pop_front();
    return index;
  }
  if (next_ == open_.size()) return std::nullopt;
  return open_[next_++].index;
}

bool Handout::lost(std::int64_t index) {
  if (++lost_[index] >= kAttempts) return false;
  again_.push_back(index);
  return true;
}

}  // namespace prehend::sweep
