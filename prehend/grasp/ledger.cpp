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

std::string to_string(Reason reason) {
  switch (reason) {
    case Reason::kDirection:
      return "approach direction out of the robot's reach";
    case Reason::kWorkspace:
      return "position outside the workspace";
    case Reason::kArm:
      return "out of the arm's reach";
    case Reason::kNothing:
      return "a pad would meet nothing";
    case Reason::kTooWide:
      return "wider than the gripper opens";
    case Reason::kOffCentre:
      return "section not centred between the fingers";
    case Reason::kTable:
      return "hand would hit the table";
    case Reason::kObject:
      return "open hand would hit the object";
    case Reason::kObstacle:
      return "hand would hit another object";
    case Reason::kBottomsOut:
      return "contact too small or sharp for the pads";
    case Reason::kTurns:
      return "closing would turn the object";
    case Reason::kFinger:
      return "a finger would touch beside its pad";
    case Reason::kFewFingers:
      return "too few fingers would touch the object";
    case Reason::kFingerTable:
      return "a finger would touch the table as it closes";
    case Reason::kFingerObstacle:
      return "a finger would touch another object as it closes";
    case Reason::kFingersMeet:
      return "fingers would touch each other";
    case Reason::kNotClosed:
      return "no force closure";
    case Reason::kTooHeavy:
      return "too heavy for the grip force";
    case Reason::kTooWeak:
      return "the motors cannot hold the load";
    case Reason::kSame:
      return "the same as a better one";
    case Reason::kRankedBelow:
      return "ranked below the best";
    case Reason::kEnough:
      return "not tried: enough others are sure to hold";
    case Reason::kNoTime:
      return "not tried: the time was used up";
  }
  return "";
}

std::string to_text(const Miss& miss) {
  const Writing writing = writing_of(miss.quantity);
  const auto [value, limit] =
      text::told_apart(writing.factor * miss.value, writing.factor * miss.limit, writing.digits);
  return fmt::format("{}{} {} {}{}", value, writing.unit, miss.value > miss.limit ? ">" : "<",
                     limit, writing.unit);
}

void Ledger::reject(Reason reason, std::string_view generator, const std::optional<Miss>& miss) {
  auto entry = std::find_if(entries_.begin(), entries_.end(), [&](const Entry& e) {
    return e.reason == reason && e.generator == generator;
  });
  if (entry == entries_.end()) {
    entries_.push_back({reason, std::string(generator), 0, std::nullopt});
    entry = entries_.end() - 1;
  }
  ++entry->count;
  if (miss && (!entry->nearest || miss->size() < entry->nearest->size())) entry->nearest = miss;
}

int Ledger::count(Reason reason) const {
  int sum = 0;
  for (const Entry& entry : entries_) sum += entry.reason == reason ? entry.count : 0;
  return sum;
}

int Ledger::total() const {
  int sum = 0;
  for (const Entry& entry : entries_) sum += entry.count;
  return sum;
}

std::vector<Rejection> Ledger::rejections(std::span<const Reason> stages) const {
  std::vector<Rejection> result;
  for (const Entry& entry : entries_) {
    result.push_back({entry.reason, entry.generator, entry.count,
                      entry.nearest ? to_text(*entry.nearest) : std::string(), entry.nearest});
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
