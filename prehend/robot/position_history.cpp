#include "prehend/robot/position_history.h"

#include <algorithm>

namespace prehend::robot {

void PositionHistory::add(std::int64_t time, Positions positions) {
  if (!entries_.empty() && time <= entries_.back().first) entries_.clear();
  entries_.emplace_back(time, std::move(positions));
  while (time - entries_.front().first > span_) entries_.pop_front();
}

std::optional<Positions> PositionHistory::at(std::int64_t time) const {
  const auto after =
      std::lower_bound(entries_.begin(), entries_.end(), time,
                       [](const auto& entry, std::int64_t sought) { return entry.first < sought; });
  if (after == entries_.end()) {
    if (entries_.empty() || time - entries_.back().first > gap_) return std::nullopt;
    return entries_.back().second;
  }
  if (after->first == time) return after->second;
  if (after == entries_.begin()) return std::nullopt;
  const auto& [begin, from] = *std::prev(after);
  if (after->first - begin > gap_) return std::nullopt;
  const double share =
      static_cast<double>(time - begin) / static_cast<double>(after->first - begin);
  return Positions(from + share * (after->second - from));
}

}  // namespace prehend::robot
