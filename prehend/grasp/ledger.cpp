#include "prehend/grasp/ledger.h"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

namespace prehend::grasp {
namespace {

std::string amount(Miss::Quantity quantity, double value) {
  switch (quantity) {
    case Miss::Quantity::kLength:
      return fmt::format("{:.1f} mm", value * 1e3);
    case Miss::Quantity::kAngle:
      return fmt::format("{:.1f} deg", value * 180 / std::numbers::pi);
    case Miss::Quantity::kForce:
      return fmt::format("{:.1f} N", value);
    case Miss::Quantity::kQuality:
      return fmt::format("{:.4f}", value);
  }
  return {};
}

}  // namespace

std::string to_text(const Miss& miss) {
  return fmt::format("{} {} {}", amount(miss.quantity, miss.value),
                     miss.value > miss.limit ? ">" : "<", amount(miss.quantity, miss.limit));
}

void Ledger::reject(std::string_view reason, std::string_view generator,
                    const std::optional<Miss>& miss) {
  auto entry = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) {
    return e.reason == reason && e.generator == generator;
  });
  if (entry == entries_.end()) {
    entries_.push_back({std::string(reason), std::string(generator), 0, std::nullopt});
    entry = entries_.end() - 1;
  }
  ++entry->count;
  if (miss && (!entry->nearest || miss->size() < entry->nearest->size())) entry->nearest = miss;
}

int Ledger::count(std::string_view reason) const {
  int sum = 0;
  for (const Entry& entry : entries_) sum += entry.reason == reason ? entry.count : 0;
  return sum;
}

int Ledger::total() const {
  int sum = 0;
  for (const Entry& entry : entries_) sum += entry.count;
  return sum;
}

std::vector<Rejection> Ledger::rejections() const {
  std::vector<Rejection> result;
  for (const Entry& entry : entries_) {
    result.push_back({entry.reason, entry.generator, entry.count,
                      entry.nearest ? to_text(*entry.nearest) : std::string()});
  }
  return result;
}

}  // namespace prehend::grasp
