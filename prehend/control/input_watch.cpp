#include "prehend/control/input_watch.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

namespace prehend::control {
namespace {

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
  return fmt::format("{} ({:.2f} s old, at most {:.2f} s)", input.name, *input.age, input.limit);
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
  was_stalled_ = false;
}

std::vector<InputAge> InputWatch::lost(double now, const std::vector<InputAge>& inputs) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const InputAge& input : inputs) shortest = std::min(shortest, input.limit);
  const bool is_late = now - std::exchange(last_, now) > shortest / 2;
  // Only one step in a row, or a slow loop would never be judged.
  was_stalled_ = is_late && !was_stalled_;
  std::vector<InputAge> lost = stale_inputs(inputs);
  std::erase_if(lost, [&](const InputAge& input) {
    const bool may_be_old = was_stalled_ || now - begun_ <= input.limit;
    const bool has_ended = input.age == std::numeric_limits<double>::infinity();
    return may_be_old && input.age && !has_ended;
  });
  return lost;
}

}  // namespace prehend::control
