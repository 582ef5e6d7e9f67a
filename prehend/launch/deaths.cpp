#include "prehend/launch/deaths.h"

#include <fmt/core.h>

#include <algorithm>

namespace prehend::launch {

void Deaths::add(const std::string& process, const std::string& how, Seconds when) {
  Entry& entry = entries_[process];
  ++entry.count;
  entry.last = how;
  entry.when = when;
  entry.for_good = true;
}

void Deaths::forgive(const std::string& process) {
  if (const auto entry = entries_.find(process); entry != entries_.end()) {
    entry->second.for_good = false;
  }
}

bool Deaths::any_for_good() const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [](const auto& entry) { return entry.second.for_good; });
}

std::vector<Deaths::Line> Deaths::lines() const {
  std::vector<Line> lines;
  for (const auto& [process, entry] : entries_) {
    const std::string times =
        entry.count == 1 ? "once" : fmt::format("{} times, last", entry.count);
    lines.push_back(
        {fmt::format("{} ended badly {} after {:.1f} s: {}{}", process, times, entry.when.count(),
                     entry.last, entry.for_good ? "" : "; it was started again"),
         entry.for_good});
  }
  return lines;
}

}  // namespace prehend::launch
