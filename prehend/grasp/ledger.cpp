#include "prehend/grasp/ledger.h"

#include <algorithm>
#include <numbers>

#include <fmt/format.h>

#include "prehend/text/told_apart.h"

namespace prehend::grasp {
namespace {

// How an amount is written: its factor to the unit, digits after the point, and the unit.
struct Writing {
  double factor;
  int digits;
  const char* unit;
};

Writing writing_of(Miss::Quantity quantity) {
  switch (quantity) {
    case Miss::Quantity::kLength:
      return {1e3, 1, " mm"};
    case Miss::Quantity::kAngle:
      return {180 / std::numbers::pi, 1, " deg"};
    case Miss::Quantity::kForce:
      return {1, 1, " N"};
    case Miss::Quantity::kQuality:
      return {1, 4, ""};
  }
  return {1, 1, ""};
}

}  // namespace

std::string to_text(const Miss& miss) {
  const Writing writing = writing_of(miss.quantity);
  const auto [value, limit] =
      text::told_apart(writing.factor * miss.value, writing.factor * miss.limit, writing.digits);
  return fmt::format("{}{} {} {}{}", value, writing.unit, miss.value > miss.limit ? ">" : "<",
                     limit, writing.unit);
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

std::vector<Rejection> Ledger::rejections(std::span<const char* const> stages) const {
  std::vector<Rejection> result;
  for (const Entry& entry : entries_) {
    result.push_back({entry.reason, entry.generator, entry.count,
                      entry.nearest ? to_text(*entry.nearest) : std::string()});
  }
  const auto stage_of = [&](const Rejection& rejection) {
    return std::find(stages.begin(), stages.end(), rejection.reason) - stages.begin();
  };
  std::stable_sort(result.begin(), result.end(), [&](const Rejection& a, const Rejection& b) {
    return stage_of(a) < stage_of(b);
  });
  return result;
}

}  // namespace prehend::grasp
