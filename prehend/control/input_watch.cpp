#include "prehend/control/input_watch.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <fmt/format.h>

#include "prehend/text/told_apart.h"

namespace prehend::control {
namespace {

constexpr int kStepsAfterStall = 3;

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
  grace_ = 0;
  was_judged_ = true;
}

// After a stall, for some steps: a loop that is slow throughout is judged in between.
bool InputWatch::may_be_behind(double now, double shortest_limit) {
  const bool is_late = now - std::exchange(last_, now) > shortest_limit / 2;
  if (grace_ > 0) {
    --grace_;
    was_judged_ = false;
  } else if (is_late && was_judged_) {
    grace_ = kStepsAfterStall - 1;
    was_judged_ = false;
  } else {
    was_judged_ = true;
  }
  return !was_judged_;
}

std::vector<InputAge> InputWatch::lost(double now, const std::vector<InputAge>& inputs) {
  double shortest = std::numeric_limits<double>::infinity();
  for (const InputAge& input : inputs) shortest = std::min(shortest, input.limit);
  const bool behind = may_be_behind(now, shortest);
  std::vector<InputAge> lost = stale_inputs(inputs);
  std::erase_if(lost, [&](const InputAge& input) {
    const bool may_be_old = behind || now - begun_ <= input.limit;
    const bool has_ended = input.age == std::numeric_limits<double>::infinity();
    return may_be_old && input.age && !has_ended;
  });
  return lost;
}

}  // namespace prehend::control
