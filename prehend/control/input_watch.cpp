#include "prehend/control/input_watch.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "prehend/text/told_apart.h"

namespace prehend::control {
namespace {

constexpr double kOnTime = 0.1;    // of the shortest limit, between steps
constexpr double kMostStalls = 4;  // of the shortest limit, of several

bool is_fresh(const InputAge& input) {
  // NaN is not fresh.
  return input.age && *input.age <= input.limit && *input.age >= -input.limit;
}

std::string describe_one(const InputAge& input) {
  if (!input.age) return input.name + " (nothing has come)";
  if (*input.age < 0) {
    return fmt::format("{} (stamped {:.2f} s in the future: set the clocks)", input.name,
                       -*input.age);
  }
  if (*input.age == std::numeric_limits<double>::infinity()) return input.name + " (ended)";
  const auto [age, limit] = text::told_apart(*input.age, input.limit, 2);
  return fmt::format("{} ({} s old, at most {} s)", input.name, age, limit);
}

}  // namespace

std::vector<InputAge> stale_inputs(const std::vector<InputAge>& inputs) {
  std::vector<InputAge> stale;
  for (const InputAge& input : inputs) {
    if (!is_fresh(input)) stale.push_back(input);
  }
  return stale;
}

std::string describe(const std::vector<InputAge>& stale) {
  std::string words;
  for (const InputAge& input : stale) words += (words.empty() ? "" : ", ") + describe_one(input);
  return words;
}

std::string names_of(const std::vector<InputAge>& inputs) {
  std::string words;
  for (const InputAge& input : inputs) words += (words.empty() ? "" : ", ") + input.name;
  return words;
}

void InputWatch::begin(double now) {
  begun_ = last_ = now;
  stalled_ = 0;
}

void InputWatch::note_stall(double now, double shortest_limit) {
  const double gap = now - std::exchange(last_, now);
  if (gap > kOnTime * shortest_limit) {
    stalled_ = std::min(stalled_ + gap, std::max(kMostStalls * shortest_limit, gap));
    last_stall_ = now;
  } else if (now - last_stall_ > shortest_limit) {
    stalled_ = 0;
  }
}

std::vector<InputAge> InputWatch::lost(double now, const std::vector<InputAge>& inputs) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const InputAge& input : inputs) shortest = std::min(shortest, input.limit);
  note_stall(now, shortest);
  std::vector<InputAge> lost = stale_inputs(inputs);
  std::erase_if(lost, [&](const InputAge& input) {
    const bool may_be_old = input.age && *input.age <= input.limit + stalled_;
    const bool was_old = now - begun_ <= input.limit;
    const bool has_ended = input.age == std::numeric_limits<double>::infinity();
    return (may_be_old || was_old) && input.age && !has_ended;
  });
  return lost;
}

}  // namespace prehend::control
