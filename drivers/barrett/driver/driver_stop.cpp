// What makes sure of a stop: it is not believed before each puck shows it.

#include <algorithm>

#include "drivers/barrett/driver/driver.h"

namespace prehend::drivers::barrett {

void Driver::send_stop(std::size_t axis, Time now) {
  Puck& puck = pucks_[axis];
  puck.steps.clear();
  puck.stop_answered = false;
  ask(axis, {Property::kMode, static_cast<int>(Mode::kIdle), Step::Kind::kStop}, now);
}

// A stop that is under way is not begun anew: its patience counts from its first message.
void Driver::stop(Time now, const std::string& why) {
  const bool moved = reading_.moving;
  begins_by_initialising_ = false;  // also before there is a hand: what is stopped begins nothing
  end_motion(why);
  reading_.blocked.fill(false);
  if (!has_line_ || !is_connected_) return;  // a connection begins with one
  if (!stopping_) stopping_ = Stopping{.began = now, .answered = {}};
  stopping_->moved = stopping_->moved || moved;
  stopping_->answered.reset();
  for (std::size_t i = 0; i < kAxes; ++i) send_stop(i, now);
  look_whether_it_moves();
}

void Driver::watch_stop(Time now) {
  if (!stopping_ || !is_connected_) return;
  Stopping& s = *stopping_;
  const bool is_answered =
      std::ranges::all_of(pucks_, [](const Puck& puck) { return puck.stop_answered; });
  if (!is_answered) return;
  if (!s.answered) s.answered = now;
  const bool is_seen = std::ranges::all_of(
      pucks_, [&](const Puck& puck) { return puck.last_position > *s.answered; });
  const bool is_parked = std::ranges::all_of(pucks_, [](const Puck& puck) {
    return !(puck.asked && puck.asked->kind == Step::Kind::kPark) &&
           std::ranges::none_of(puck.steps,
                                [](const Step& step) { return step.kind == Step::Kind::kPark; });
  });
  if (is_seen && is_parked && !reading_.moving) {
    if (s.moved) note_(false, "stopped");
    stopping_.reset();
    return;
  }
  if (!reading_.moving || now - *s.answered < to_time(options_.stop_time)) return;
  if (!s.is_off) {
    note_(true, "the hand moves on although stop was answered: its motors are told to switch off");
  }
  s.is_off = true;
  s.answered.reset();
  for (std::size_t i = 0; i < kAxes; ++i) {
    order(i, Property::kCommand, static_cast<int>(Command::kOff));
    send_stop(i, now);
  }
}

}  // namespace prehend::drivers::barrett
