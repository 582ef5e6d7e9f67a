#include "prehend/robot/formats/loss_report.h"

#include <algorithm>
#include <numeric>
#include <tuple>

#include <fmt/format.h>

namespace prehend::robot::formats {

std::size_t LossReport::count(Entry::Fate fate) const {
  return static_cast<std::size_t>(std::count_if(
      entries_.begin(), entries_.end(), [fate](const Entry& one) { return one.fate == fate; }));
}

std::string LossReport::text() const {
  // Equal ones once, at their first place.
  std::vector<std::pair<const Entry*, std::size_t>> lines;
  std::map<std::tuple<Entry::Fate, std::string, std::string>, std::size_t> known;
  for (const Entry& entry : entries_) {
    const auto [at, is_new] = known.try_emplace({entry.fate, entry.what, entry.why}, lines.size());
    if (is_new) {
      lines.emplace_back(&entry, 1);
    } else {
      ++lines[at->second].second;
    }
  }
  std::string text, extended;
  for (const auto& [entry, count] : lines) {
    if (entry->fate == Entry::Fate::kExtended && entry->why.empty()) {
      extended +=
          fmt::format("{}: kept in prehend's extension, which other programs do not read: {}\n",
                      entry->place, entry->what);
      continue;
    }
    const char* fate = entry->fate == Entry::Fate::kDropped        ? "dropped"
                       : entry->fate == Entry::Fate::kApproximated ? "approximated"
                                                                   : "for others approximated";
    text += fmt::format("{}: {} {}{}: {}\n", entry->place, fate, entry->what,
                        count > 1 ? fmt::format(" ({} times)", count) : "", entry->why);
  }
  const std::size_t kept =
      std::accumulate(kept_.begin(), kept_.end(), std::size_t{0},
                      [](std::size_t sum, const auto& one) { return sum + one.second; });
  return text + extended +
         fmt::format("{} elements and attributes kept, {} approximated, {} dropped\n", kept,
                     count(Entry::Fate::kApproximated), count(Entry::Fate::kDropped));
}

}  // namespace prehend::robot::formats
