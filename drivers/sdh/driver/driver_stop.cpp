// What makes sure of a stop: it is not believed before states show it.

#include <algorithm>
#include <cstdio>
#include <string_view>

#include "drivers/sdh/driver/driver.h"

namespace prehend::drivers::sdh {
namespace {

// The line's end first: a half-typed command must not swallow it.
constexpr std::string_view kStop = "\r\nstop\r\n";

}  // namespace

void Driver::send_stop(Time now) {
  exchange_ = Exchange{Command::kStop, {}, false, now, 1};
  stopping_->last_sent = now;
  send_({reinterpret_cast<const std::uint8_t*>(kStop.data()), kStop.size()});
}

// A stop that is under way is not begun anew: its patience counts from its first message.
void Driver::stop(Time now, const std::string& why) {
  end_motion(why);
  reading_.blocked.fill(false);
  parks_ = false;
  if (!has_line_ || connect_ != Connect::kDone) return;  // a connection begins with one
  const bool moved = reading_.moving;
  if (!stopping_)
    stopping_ = Stopping{.began = now, .last_sent = now, .moved = moved, .answered = {}};
  stopping_->moved = stopping_->moved || moved;
  drains_until_.reset();
  send_stop(now);
}

void Driver::power_off(Time now, const std::string& why) {
  end_motion(why);
  reading_.blocked.fill(false);
  stopping_.reset();
  parks_ = false;
  if (!has_line_ || connect_ != Connect::kDone) return;
  powers_off_ = true;
  exchange_.reset();
  drains_until_.reset();
  power_off_sent_ = now;
  ask(Command::kPower, std::vector<double>(kAxes, 0.0), now);
}

void Driver::stop_is_done(Time now) {
  const bool moved = stopping_->moved;
  stopping_.reset();
  parks_ = true;
  held_ = reading_.position;
  if (moved) note_(false, "stopped");
  static_cast<void>(now);
}

void Driver::watch_stop(Time now) {
  if (powers_off_) {
    const bool is_off = std::ranges::all_of(
        reading_.axes, [](AxisState state) { return state == AxisState::kDisabled; });
    if (is_off && last_state_ > power_off_sent_) {
      powers_off_ = false;
      parks_ = true;
      held_ = reading_.position;
    }
    return;
  }
  if (!stopping_ || connect_ != Connect::kDone) return;
  Stopping& s = *stopping_;
  if (s.answered) {
    if (last_state_ > *s.answered && !reading_.moving) return stop_is_done(now);
    if (now - *s.answered < to_time(options_.stop_time) || !reading_.moving) return;
    note_(true, "the hand moves on although stop was answered: its axes are switched off");
    return power_off(now, "switched off, as it did not stop");
  }
  if (now - s.last_sent < to_time(options_.stop_repeat)) return;
  if (s.tries <= options_.tries) {
    ++s.tries;
    ++counters_.unanswered;
    return send_stop(now);
  }
  if (s.moved) {
    note_(true, "stop is not answered: the axes are switched off");
    return power_off(now, "switched off, as stop was not answered");
  }
  note_(true, "no answer to stop");
  exchange_.reset();
  stopping_.reset();
}

}  // namespace prehend::drivers::sdh
