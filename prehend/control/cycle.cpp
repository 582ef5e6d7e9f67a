#include "prehend/control/cycle.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "prehend/text/require.h"

namespace prehend::control {

std::string to_string(Phase phase) {
  switch (phase) {
    case Phase::kWaiting:
      return "waiting";
    case Phase::kSpawn:
      return "spawn";
    case Phase::kApproach:
      return "approach";
    case Phase::kGrasp:
      return "grasp";
    case Phase::kLift:
      return "lift";
    case Phase::kMove:
      return "move";
    case Phase::kRelease:
      return "release";
    case Phase::kDone:
      return "done";
    case Phase::kFailed:
      return "failed";
    case Phase::kPush:
      return "push";
  }
  return "unknown";
}

void SharedCycleOptions::validate() const {
  const text::Require require{"CycleOptions."};
  require(!task.states.empty(), "task must have states");
  require(largest_attempts > 0, "largest_attempts must be positive");
  knobs(*this, text::CheckKnobs{"CycleOptions."});
  require(std::isfinite(look_timeout) && look_timeout >= 0, "look_timeout must not be negative");
  tolerances.validate();
}

Primitive Cycle::primitive() const {
  return task().states[static_cast<std::size_t>(state_)].action.primitive;
}

Phase Cycle::phase() const {
  switch (stage_) {
    case Stage::kWaiting:
      return Phase::kWaiting;
    case Stage::kDone:
      return Phase::kDone;
    case Stage::kFailed:
      return Phase::kFailed;
    case Stage::kActing:
      break;
  }
  switch (primitive()) {
    case Primitive::kLook:
    case Primitive::kDecide:
    case Primitive::kView:
    case Primitive::kWait:
      return Phase::kWaiting;
    case Primitive::kApproach:
    case Primitive::kTouch:
    case Primitive::kProbe:
      return Phase::kApproach;
    case Primitive::kPush:
      return Phase::kPush;
    case Primitive::kGrasp:
      return Phase::kGrasp;
    case Primitive::kLift:
      return Phase::kLift;
    case Primitive::kMove:
    case Primitive::kPlace:
    case Primitive::kInspect:
      return Phase::kMove;
    case Primitive::kRelease:
    case Primitive::kRetreat:
      return Phase::kRelease;
  }
  return Phase::kWaiting;
}

void Cycle::start_task(std::vector<GraspPose> grasps, const std::string& problem, Advice advice) {
  result_ = {};
  surprises_.clear();
  phase_times_.clear();
  failed_attempts_.clear();
  failure_.clear();
  achieved_.clear();
  path_.clear();
  grasp_index_ = attempts_ = touches_ = looks_ = given_up_ = pushes_ = 0;
  looking_ = any_object_ = at_place_ = touched_ = probed_ = viewing_ = false;
  pushed_ = push_is_made_ = false;
  after_view_ = nullptr;
  advice_ = std::move(advice);
  entered_ = now_;
  stage_ = Stage::kWaiting;
  const bool none = grasps.empty();
  order_.start(std::move(grasps));
  if (advice_.first && !none) order_.prefer(*advice_.first);
  fresh_ = true;
  stuck_ = problem.empty() ? "the plan has no grasps" : problem;
  if (none && !(task().does(Primitive::kPush) && push_grasp())) finish(false, stuck_);
}

void Cycle::begin_task() {
  done_.assign(task().states.size(), 0);
  enter(task().start);
}

void Cycle::enter(int state) {
  path_.push_back(state);
  if (state < 0) return;
  stage_ = Stage::kActing;
  state_ = state;
  const Action& action = task().states[static_cast<std::size_t>(state)].action;
  if (action.primitive == Primitive::kLook) return look();
  if (action.primitive == Primitive::kDecide) return decide();
  if (action.primitive == Primitive::kView) return view();
  if (action.primitive == Primitive::kProbe) return probe(action);
  if (action.primitive == Primitive::kPush) return push(action);
  begin(action);
}

void Cycle::ended(Outcome outcome, const std::string& reason) {
  const std::size_t index = static_cast<std::size_t>(state_);
  const TaskState& state = task().states[index];
  if (outcome == Outcome::kDone && state.action.primitive == Primitive::kPlace) at_place_ = true;
  if (outcome != Outcome::kDone && state.action.primitive == Primitive::kLook) stuck_ = reason;
  if (outcome == Outcome::kDone && state.action.primitive == Primitive::kRetreat && at_place_ &&
      failure_.empty()) {
    ++result_.placed;
    pushes_ = given_up_ = 0;
  }
  int next = state.next.at(outcome);
  if (outcome == Outcome::kDone && state.times > 0 && ++done_[index] >= state.times) {
    done_[index] = 0;
    next = state.then;
  }
  if (next >= 0) return enter(next);
  path_.push_back(next);
  if (next == kSuccess) {
    std::string text = achieved_;
    if (task().all_objects) {
      text = fmt::format("{} {} put at {} place{}", result_.placed,
                         result_.placed == 1 ? "object was" : "objects were",
                         result_.placed == 1 ? "its" : "their",
                         achieved_.empty() ? "" : "; the last: " + achieved_);
    }
    if (!reason.empty()) text += (text.empty() ? "" : "; ") + reason;
    return finish(true, text.empty() ? "the task is done" : text);
  }
  const bool said = failure_.empty() || reason.find(failure_) != std::string::npos;
  finish(false, said ? reason : failure_ + (reason.empty() ? "" : "; " + reason));
}

void Cycle::finish(bool success, const std::string& reason) {
  result_.outcome = success ? CycleOutcome::kSucceeded : CycleOutcome::kFailed;
  result_.reason = reason;
  looking_ = false;
  stage_ = success ? Stage::kDone : Stage::kFailed;
  entered(reason);
}

void Cycle::abort(const std::string& reason) {
  if (finished()) return;
  stop_motion();
  finish(false, reason);
}

// The first grasp of a plan, or another after a failure, or of another object.
void Cycle::look() {
  if (fresh_) {
    if (const std::optional<int> first = order_.next()) return attempt(*first);
    fresh_ = false;
    return ended(Outcome::kNothing, stuck_);
  }
  if (std::exchange(pushed_, false)) {
    failure_.clear();
    any_object_ = true;
    if (shared_.look_timeout > 0) return clear_view();
    return ended(Outcome::kNothing, "nothing new is seen, as look_timeout is 0");
  }
  // A probe that failed is no reason to leave a grasp.
  if (touched_ && (failure_.empty() || probed_)) {
    any_object_ = false;
    if (shared_.look_timeout > 0) return clear_view();
    return next_grasp("");
  }
  const bool failed = !failure_.empty() || (task().all_objects && !at_place_);
  any_object_ = !failed;
  if (failed) {
    if (failure_.empty()) {
      failure_ = fmt::format("grasp {}: the object was not put at its place", grasp_index_);
      failed_attempts_.add(0, failure_);
    }
    order_.fail(grasp_index_);
    if (attempts_ >= shared_.largest_attempts) {
      if (!task().all_objects) return ended(Outcome::kFailed, failed_attempts_.text());
      object_ended();
    }
  }
  if (any_object_) {
    if (result_.placed + given_up_ >= task().most_objects) {
      return ended(given_up_ > 0 ? Outcome::kFailed : Outcome::kNothing,
                   fmt::format("{} objects are the most of this task", task().most_objects));
    }
    if (shared_.look_timeout == 0) {
      return ended(Outcome::kFailed, "nothing new is seen, as look_timeout is 0");
    }
    return clear_view();
  }
  if (shared_.look_timeout > 0) return clear_view();
  next_grasp("");
}

// The plan's advice holds once: after a touch that told nothing new there is none.
void Cycle::decide() {
  const Advice advice = std::exchange(advice_, {});
  const bool probes = advice.act == Advice::Act::kProbe && probe_grasp().has_value();
  const bool touches =
      (advice.act == Advice::Act::kTouch || probes) && touches_ < shared_.largest_touches;
  const bool looks = advice.act == Advice::Act::kLook && looks_ < shared_.largest_looks &&
                     shared_.look_timeout > 0;
  if (looks) return look_from_elsewhere(advice);
  const bool gives_up = advice.act == Advice::Act::kGiveUp;
  if (!touches && !gives_up) return ended(Outcome::kDone);
  // Neither is an attempt. An object that is left counts all the same, or it is looked at for ever.
  if (gives_up) {
    --result_.attempts;
    order_.put_back(grasp_index_);
    failure_ = advice.why;
    failed_attempts_.add(0, advice.why);
    return ended(Outcome::kNothing, advice.why);
  }
  feel_with(probes ? *probe_grasp() : advice.grasp);
  ended(Outcome::kDoubtful, advice.why);
}

void Cycle::view() {
  const Advice advice = std::exchange(advice_, {});
  const char* why = nullptr;
  if (shared_.look_timeout == 0) {
    why = "nothing new is seen, as look_timeout is 0";
  } else if (looks_ >= shared_.largest_looks) {
    why = "it was looked at from elsewhere as often as largest_looks allows";
  } else if (advice.look.points.empty()) {
    why = "the plan has no look from elsewhere";
  }
  if (why) return ended(Outcome::kNothing, why);
  look_from_elsewhere(advice);
}

void Cycle::look_from_elsewhere(const Advice& advice) {
  --result_.attempts;
  order_.put_back(grasp_index_);
  --attempts_;
  ++looks_;
  ++result_.looks;
  any_object_ = false;
  viewing_ = true;
  go_to_view(advice.look);
}

void Cycle::look_failed(const std::string& why) {
  after_view([this, why] { next_grasp(why); });
}

void Cycle::after_view(std::function<void()> next) {
  viewing_ = looking_ = false;
  after_view_ = std::move(next);
  leave_view();
}

void Cycle::view_left() {
  const std::function<void()> next = std::exchange(after_view_, nullptr);
  next();
}

void Cycle::probe(const Action& action) {
  const std::optional<int> index = probe_grasp();
  if (!index) return ended(Outcome::kNothing, "the plan has no probe");
  if (touches_ >= shared_.largest_touches) {
    return ended(Outcome::kNothing, "it was felt as often as largest_touches allows");
  }
  feel_with(*index);
  begin(action);
}

void Cycle::push(const Action& action) {
  const std::optional<int> index = push_grasp();
  const char* why = nullptr;
  if (!index) {
    why = "nothing is to be pushed";
  } else if (pushes_ >= shared_.largest_pushes) {
    why = "things were pushed as often as largest_pushes allows";
  } else if (push_is_made_) {
    why = "what the last plan has to be pushed was pushed";
  }
  if (why) return ended(Outcome::kNothing, stuck_ + (stuck_.empty() ? "" : "; ") + why);
  ++pushes_;
  ++result_.pushes;
  pushed_ = push_is_made_ = true;
  given_up_ = 0;
  at_place_ = touched_ = probed_ = false;
  failure_.clear();
  grasp_index_ = *index;
  attempts_surprises_ = surprises_.size();
  prepare_attempt();
  begin(action);
}

void Cycle::feel_with(int grasp_index) {
  --result_.attempts;
  order_.put_back(grasp_index_);
  --attempts_;
  ++touches_;
  ++result_.touches;
  probed_ = probe_grasp() == grasp_index;
  grasp_index_ = grasp_index;
  if (!probed_) result_.grasp_index = grasp_index;
  touched_ = true;
  prepare_attempt();
}

// What the last attempt was with is given up; any other is looked for.
void Cycle::object_ended() {
  ++given_up_;
  any_object_ = true;
}

void Cycle::look_now() {
  looking_ = true;
  if (viewing_) return entered("looking at it from there");
  entered(any_object_ ? "looking for what is left"
                      : (failure_.empty() ? "felt it" : failure_) + "; looking again");
}

std::optional<double> Cycle::looks_since() const {
  return looking_ ? std::optional(entered_) : std::nullopt;
}

void Cycle::step_look() {
  if (spent() <= shared_.look_timeout) return;
  if (viewing_) return look_failed("no new plan came");
  next_grasp("no new plan came");
}

void Cycle::plan_taken(std::vector<GraspPose> grasps, const std::string& problem, Advice advice) {
  push_is_made_ = false;
  if (grasps.empty()) {
    const std::string why = "the new look gives no grasp" + (problem.empty() ? "" : ": " + problem);
    return viewing_ ? look_failed(why) : next_grasp(why);
  }
  viewing_ = false;  // its motions begin where the arm stands now
  advice_ = std::move(advice);
  if (any_object_) {
    order_.start(std::move(grasps));
    attempts_ = touches_ = looks_ = 0;
  } else {
    order_.take(std::move(grasps));
  }
  if (advice_.first) order_.prefer(*advice_.first);
  ++result_.plans;
  attempt(order_.next().value_or(0));
}

// Of a look: those of `decide` and `view`, from elsewhere, have no other word for it.
Outcome Cycle::in_vain() const {
  return primitive() == Primitive::kLook ? Outcome::kFailed : Outcome::kNothing;
}

// `why` it is not a grasp of a new look, in words; empty: nobody looked.
void Cycle::next_grasp(const std::string& why) {
  looking_ = false;
  if (any_object_) {
    const std::string left =
        given_up_ == 0 ? why : fmt::format("{} given up: {}", given_up_, failed_attempts_.text());
    return ended(given_up_ > 0 ? in_vain() : Outcome::kNothing, left);
  }
  const std::optional<int> next = order_.next();
  const bool out_of_date = shared_.only_seen_again && !why.empty();
  if (!next || out_of_date || attempts_ >= shared_.largest_attempts) {
    const std::string text = failed_attempts_.text() + (why.empty() ? "" : "; " + why);
    if (!task().all_objects) return ended(in_vain(), text);
    object_ended();
    return clear_view();
  }
  const std::string before = why.empty() ? "" : why + ": the next grasp of the plan before; ";
  attempt(*next);
  if (!before.empty()) detail_ = before + detail_;
}

void Cycle::attempt(int grasp_index) {
  looking_ = fresh_ = at_place_ = touched_ = probed_ = false;
  ++result_.attempts;
  ++attempts_;
  result_.grasp_index = grasp_index_ = grasp_index;
  failure_.clear();
  attempts_surprises_ = surprises_.size();
  order_.begin(grasp_index);
  prepare_attempt();
  // After a look from elsewhere it is decided anew, by the plan of that.
  if (primitive() == Primitive::kDecide) return decide();
  ended(Outcome::kDone);
}

void Cycle::advance_to(double time) {
  if (!phase_times_.empty()) phase_times_.back().second += std::max(0.0, time - now_);
  now_ = time;
}

void Cycle::entered(const std::string& detail) {
  detail_ = detail;
  entered_ = now_;
  const std::string name = to_string(phase());
  if (finished() || (!phase_times_.empty() && phase_times_.back().first == name)) return;
  phase_times_.emplace_back(name, 0.0);
}

void Cycle::add_surprise(SurpriseKind kind, double predicted, double felt,
                         const std::string& reaction) {
  surprises_.push_back(compare(kind, predicted, felt, shared_.tolerances, reaction));
}

void Cycle::give_up(const std::string& reason, SurpriseKind kind, Outcome outcome) {
  failure_ = reason;
  if (primitive() != Primitive::kPush) {
    failed_attempts_.add(static_cast<int>(primitive()), reason);
  }
  const bool surprised =
      std::any_of(surprises_.begin() + static_cast<std::ptrdiff_t>(attempts_surprises_),
                  surprises_.end(), [](const Surprise& surprise) { return surprise.surprising; });
  if (!surprised) add_surprise(kind, 1, 0, "lets go and looks again");
  stop_motion();
  ended(outcome, reason);
}

}  // namespace prehend::control
