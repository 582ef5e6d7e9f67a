#include "prehend/graph/link/node_health.h"

#include <utility>

namespace prehend::graph {

bool NodeHealth::say(const Word& own) { return std::exchange(own_, own) != own; }

bool NodeHealth::fail(const Word& failure, Time now) {
  ++failures_;
  failed_ = now;
  return std::exchange(failure_, failure) != failure;
}

void NodeHealth::hold(const std::string& about, const std::string& text) {
  std::string& held = held_[about];
  held += (held.empty() ? "" : "; ") + text;
}

bool NodeHealth::take_news(Time now, Word& word) {
  if (now - failed_ >= kFailureCounts) failure_ = {};
  word = own_;
  if (!held_.empty()) word = {Health::kError, held_.begin()->second};
  if (failure_.level != Health::kOk && failure_.level >= word.level) word = failure_;
  return std::exchange(told_, word) != word;
}

}  // namespace prehend::graph
