#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <optional>
#include <random>
#include <utility>

#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// How often a line harms what it carries. Probabilities are of each item by itself.
struct LineFaults {
  double dropped = 0;
  double duplicated = 0;
  double corrupted = 0;
  double late = 0;  // probability that an item comes `delay` later
  Time delay{};     // of late items; others overtake them
};

/// A line that drops, delays, doubles and corrupts items on request; by default it does nothing.
/// Same seed and same calls, same faults.
template <class Item>
class FaultyLine {
 public:
  using Corrupt = std::function<void(Item&, std::mt19937_64&)>;
  explicit FaultyLine(Corrupt corrupt, std::uint64_t seed = 1)
      : corrupt_(std::move(corrupt)), random_(seed) {}

  void set_faults(const LineFaults& faults) { faults_ = faults; }

  void push(Item item, Time now) {
    if (happens(faults_.dropped)) return;
    if (happens(faults_.corrupted)) corrupt_(item, random_);
    const Time due = happens(faults_.late) ? now + faults_.delay : now;
    if (happens(faults_.duplicated)) insert(item, due);
    insert(std::move(item), due);
  }
  /// The next item that is due at `now`.
  std::optional<Item> pop(Time now) {
    auto next = next_due(now);
    if (!next) return std::nullopt;
    return std::move(next->second);
  }
  /// The same, and when it was due.
  std::optional<std::pair<Time, Item>> next_due(Time now) {
    if (items_.empty() || items_.front().first > now) return std::nullopt;
    std::pair<Time, Item> next = std::move(items_.front());
    items_.pop_front();
    return next;
  }
  void clear() { items_.clear(); }
  /// Faults so far.
  std::uint64_t harmed() const { return harmed_; }

 private:
  bool happens(double probability) {
    const bool does =
        probability > 0 && std::uniform_real_distribution<double>(0, 1)(random_) < probability;
    harmed_ += does;
    return does;
  }
  void insert(Item item, Time due) {
    const auto behind = std::upper_bound(
        items_.begin(), items_.end(), due,
        [](Time time, const std::pair<Time, Item>& other) { return time < other.first; });
    items_.insert(behind, {due, std::move(item)});
  }

  Corrupt corrupt_;
  std::mt19937_64 random_;
  LineFaults faults_;
  std::uint64_t harmed_ = 0;
  std::deque<std::pair<Time, Item>> items_;  // by the time they are due
};

}  // namespace prehend::drivers
