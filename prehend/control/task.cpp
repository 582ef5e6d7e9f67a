#include "prehend/control/task.h"

#include <algorithm>

#include <fmt/format.h>

#include "prehend/geometry/errors.h"

namespace prehend::control {

std::string to_string(Primitive primitive) {
  switch (primitive) {
    case Primitive::kLook:
      return "look";
    case Primitive::kApproach:
      return "approach";
    case Primitive::kTouch:
      return "touch";
    case Primitive::kGrasp:
      return "grasp";
    case Primitive::kLift:
      return "lift";
    case Primitive::kMove:
      return "move";
    case Primitive::kPlace:
      return "place";
    case Primitive::kRelease:
      return "release";
    case Primitive::kRetreat:
      return "retreat";
    case Primitive::kWait:
      return "wait";
    case Primitive::kDecide:
      return "decide";
    case Primitive::kProbe:
      return "probe";
    case Primitive::kView:
      return "view";
    case Primitive::kInspect:
      return "inspect";
    case Primitive::kPush:
      return "push";
  }
  return "unknown";
}

std::string to_string(Outcome outcome) {
  switch (outcome) {
    case Outcome::kDone:
      return "done";
    case Outcome::kNothing:
      return "nothing";
    case Outcome::kFailed:
      return "failed";
    case Outcome::kLost:
      return "lost";
    case Outcome::kDoubtful:
      return "doubtful";
  }
  return "unknown";
}

const std::vector<Outcome>& outcomes_of(Primitive primitive) {
  using enum Outcome;
  static const std::vector<Outcome> done{kDone}, failed{kDone, kFailed},
      nothing{kDone, kNothing, kFailed}, lost{kDone, kFailed, kLost},
      all{kDone, kNothing, kFailed, kLost}, decided{kDone, kDoubtful, kNothing},
      viewed{kDone, kNothing};
  switch (primitive) {
    case Primitive::kLook:
    case Primitive::kTouch:
    case Primitive::kProbe:
    case Primitive::kPush:
      return nothing;
    case Primitive::kApproach:
    case Primitive::kGrasp:
    case Primitive::kRelease:
    case Primitive::kRetreat:
      return failed;
    case Primitive::kLift:
    case Primitive::kPlace:
      return lost;
    case Primitive::kMove:
    case Primitive::kInspect:
      return all;
    case Primitive::kWait:
      return done;
    case Primitive::kDecide:
      return decided;
    case Primitive::kView:
      return viewed;
  }
  return done;
}

const TaskPlace* Task::place_for(double size) const {
  if (places.empty()) return nullptr;
  for (const TaskPlace& place : places) {
    if (!place.up_to || size <= *place.up_to) return &place;
  }
  throw geometry::InputError(
      fmt::format("the task '{}' has no place for a thing of {:.0f} mm", name, 1e3 * size),
      "Leave `up_to` out of the last of its places");
}

bool Task::is_placed(const Eigen::Vector2d& p_W) const {
  return std::any_of(places.begin(), places.end(),
                     [&p_W](const TaskPlace& place) { return place.holds(p_W); });
}

bool Task::does(Primitive primitive) const {
  return std::any_of(states.begin(), states.end(), [primitive](const TaskState& state) {
    return state.action.primitive == primitive;
  });
}

std::string Task::name_of(int state) const {
  if (state == kSuccess) return "success";
  if (state == kFailure) return "failure";
  return states.at(static_cast<std::size_t>(state)).name;
}

}  // namespace prehend::control
