#include "prehend/control/task_check.h"

#include <array>
#include <functional>
#include <optional>
#include <set>

#include <fmt/format.h>

namespace prehend::control {
namespace {

/// What is known of hand and object between two actions.
enum class Standing {
  kAway,      // hand open and away, no object chosen
  kChosen,    // the same, a grasp chosen
  kAtObject,  // hand open round the object
  kTouched,   // closed until it touches, the object stands
  kGripped,   // closed, the object stands
  kRaised,    // held as high as it is lifted
  kHalfway,   // held, lower
  kLowered,   // held, stands where it stood
  kAbovePlace,
  kAtPlace,  // held, stands at its place
  kUnsure,   // something went wrong
  kOpened,   // let go, hand still there
};

const char* words_of(Standing standing) {
  switch (standing) {
    case Standing::kAway:
      return "no object is chosen";
    case Standing::kChosen:
      return "the hand is away from the object";
    case Standing::kAtObject:
      return "the hand is open round the object";
    case Standing::kTouched:
      return "the object is touched, not gripped";
    case Standing::kGripped:
      return "the object is gripped and stands";
    case Standing::kRaised:
      return "the object is held, lifted";
    case Standing::kHalfway:
      return "the object is held, lowered in part";
    case Standing::kLowered:
      return "the object is held and stands where it stood";
    case Standing::kAbovePlace:
      return "the object is held above its place";
    case Standing::kAtPlace:
      return "the object is held and stands at its place";
    case Standing::kUnsure:
      return "something has failed and the hand is not open";
    case Standing::kOpened:
      return "the hand has let go and is still at the object";
  }
  return "";
}

/// Where an action that begins at one of `from` leads to when it is done. What is lost or fails
/// leaves all unsure, but where `otherwise` says something else.
struct Rule {
  std::set<Standing> from;
  Standing done;
  std::map<Outcome, Standing> otherwise = {};
};

Rule rule_of(const Action& action) {
  using enum Standing;
  switch (action.primitive) {
    case Primitive::kLook:
      return {{kAway, kChosen}, kChosen, {{Outcome::kNothing, kAway}, {Outcome::kFailed, kAway}}};
    case Primitive::kApproach:
      return {{kChosen}, kAtObject};
    case Primitive::kTouch:
      return {{kChosen}, kAtObject, {{Outcome::kNothing, kAtObject}}};
    case Primitive::kGrasp:
      return {{kAtObject}, action.gently ? kTouched : kGripped};
    case Primitive::kLift:
      return {{kGripped}, kRaised};
    case Primitive::kMove:
      switch (action.goal) {
        case Action::Goal::kPlace:
          return {{kRaised}, kAbovePlace, {{Outcome::kNothing, kRaised}}};
        case Action::Goal::kLowered:
          return {{kRaised, kHalfway}, action.share < 1 ? kHalfway : kLowered};
        case Action::Goal::kLifted:
          return {{kRaised, kHalfway, kLowered}, kRaised};
      }
      break;
    case Primitive::kPlace:
      return {{kAbovePlace}, kAtPlace};
    case Primitive::kRelease:
      // A hand that does not open is no reason to stay where it is.
      return {{kAtObject, kTouched, kGripped, kLowered, kAtPlace, kUnsure},
              kOpened,
              {{Outcome::kFailed, kOpened}}};
    case Primitive::kRetreat:
      return {{kAtObject, kOpened}, kAway};
    case Primitive::kDecide:
      return {{kChosen}, kChosen, {{Outcome::kDoubtful, kChosen}, {Outcome::kNothing, kAway}}};
    case Primitive::kView:
      return {{kChosen}, kChosen, {{Outcome::kNothing, kChosen}}};
    case Primitive::kProbe:
      return {{kChosen}, kAtObject, {{Outcome::kNothing, kChosen}}};
    case Primitive::kPush:
      return {{kAway}, kAtObject, {{Outcome::kNothing, kAway}}};
    case Primitive::kInspect:
      return {{kRaised}, kRaised, {{Outcome::kNothing, kRaised}, {Outcome::kFailed, kRaised}}};
    case Primitive::kWait:
      break;
  }
  return {{}, kAway};
}

std::optional<Standing> standing_after(const Action& action, Standing before, Outcome outcome) {
  if (action.primitive == Primitive::kWait) return before;
  const Rule rule = rule_of(action);
  if (!rule.from.contains(before)) return std::nullopt;
  if (outcome == Outcome::kDone) return rule.done;
  const auto other = rule.otherwise.find(outcome);
  return other == rule.otherwise.end() ? Standing::kUnsure : other->second;
}

/// Every (outcome, next) of a state; `then` is where kDone leads to, too.
std::vector<std::pair<Outcome, int>> ways_on(const TaskState& state) {
  std::vector<std::pair<Outcome, int>> ways(state.next.begin(), state.next.end());
  if (state.times > 0) ways.emplace_back(Outcome::kDone, state.then);
  return ways;
}

class Checker {
 public:
  explicit Checker(const Task& task) : task_(task), known_(task.states.size()) {}

  TaskProblem problem() {
    if (TaskProblem found = walk(); !found.what.empty()) return found;
    for (int i = 0; i < size(); ++i) {
      if (known_[place(i)].empty()) {
        return {i, "cannot be reached from the start", "Lead to it, or take it out"};
      }
    }
    for (int i = 0; i < size(); ++i) {
      if (!reaches_end(i)) {
        return {i, "never comes to an end", "Lead from there to success or failure"};
      }
    }
    return endless();
  }

 private:
  int size() const { return static_cast<int>(task_.states.size()); }
  static std::size_t place(int state) { return static_cast<std::size_t>(state); }

  TaskProblem walk() {
    std::vector<std::pair<int, Standing>> open{{task_.start, Standing::kAway}};
    std::map<std::pair<int, Standing>, std::string> from{{open.front(), "the start"}};
    while (!open.empty()) {
      const auto [index, standing] = open.back();
      open.pop_back();
      known_[place(index)].insert(standing);
      const TaskState& state = task_.states[place(index)];
      for (const auto& [outcome, next] : ways_on(state)) {
        const auto after = standing_after(state.action, standing, outcome);
        if (!after) {
          return {index,
                  fmt::format("cannot {} when it comes from {}, as {} then",
                              to_string(state.action.primitive), from.at({index, standing}),
                              words_of(standing)),
                  "Lead to it from another state"};
        }
        if (next < 0 || !from.try_emplace({next, *after}, "'" + state.name + "'").second) continue;
        open.emplace_back(next, *after);
      }
    }
    return {};
  }

  bool reaches_end(int from) const {
    std::set<int> seen{from};
    std::vector<int> open{from};
    while (!open.empty()) {
      const TaskState& state = task_.states[place(open.back())];
      open.pop_back();
      for (const auto& [outcome, next] : ways_on(state)) {
        if (next < 0) return true;
        if (seen.insert(next).second) open.push_back(next);
      }
    }
    return false;
  }

  // A way round that passes neither a look nor a state with `times`.
  TaskProblem endless() const {
    std::vector<char> color(task_.states.size(), 0);  // 1: on the way, 2: done
    const std::function<int(int)> visit = [&](int index) -> int {
      color[place(index)] = 1;
      for (const auto& [outcome, next] : task_.states[place(index)].next) {
        if (next < 0 || bounded(next) || color[place(next)] == 2) continue;
        if (color[place(next)] == 1) return next;
        if (const int found = visit(next); found >= 0) return found;
      }
      color[place(index)] = 2;
      return -1;
    };
    for (int i = 0; i < size(); ++i) {
      if (bounded(i) || color[place(i)] != 0) continue;
      if (const int found = visit(i); found >= 0) {
        return {found, "can go round for ever",
                "Give a state on the way round `times` and `then`, or pass a look"};
      }
    }
    return {};
  }
  bool bounded(int index) const {
    const TaskState& state = task_.states[place(index)];
    return state.times > 0 || state.action.primitive == Primitive::kLook;
  }

  const Task& task_;
  std::vector<std::set<Standing>> known_;
};

}  // namespace

TaskProblem problem_of(const Task& task) { return Checker(task).problem(); }

}  // namespace prehend::control
