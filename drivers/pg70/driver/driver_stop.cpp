// What makes sure of a stop, and of a grip: neither is believed before states show it.

#include <cmath>
#include <cstdio>

#include "drivers/pg70/driver/driver.h"

namespace prehend::drivers::pg70 {
namespace {

std::string millimetres(double metres) {
  char text[32];
  std::snprintf(text, sizeof text, "%.1f mm", 1e3 * metres);
  return text;
}

}  // namespace

void Driver::stop(Time now, const std::string& why) {
  end_motion(why);
  referencing_ = false;
  reading_.blocked = false;
  if (link_up_) begin_stopping(now, false);
}

void Driver::fast_stop(Time now, const std::string& why) {
  end_motion(why);
  referencing_ = false;
  reading_.blocked = false;
  if (link_up_) begin_stopping(now, true);
}

// A stop that is under way is not begun anew: its patience counts from its first message.
void Driver::begin_stopping(Time now, bool is_fast) {
  const Command command = is_fast ? Command::kFastStop : Command::kStop;
  if (!stopping_ || is_fast) {
    stopping_ =
        Stopping{.last_sent = now, .moved = reading_.moving, .is_fast = is_fast, .answered = {}};
  }
  send_(encode(PlainRequest{command}));
}

void Driver::watch_stop(Time now) {
  if (!stopping_) return;
  Stopping& s = *stopping_;
  if (reading_.error_code != 0) return stopping_.reset();  // motor off; fault() has told it
  if (!s.is_fast && s.answered && last_state_ > *s.answered && !reading_.moving) {
    if (s.moved) note_(false, "stopped at " + millimetres(reading_.opening));
    return stopping_.reset();
  }
  if (now - s.last_sent < to_time(options_.reply_time)) return;
  if (s.is_fast) {
    s.last_sent = now;
    ++counters_.unanswered;
    send_(encode(PlainRequest{Command::kFastStop}));
  } else if (s.answered) {
    if (now - *s.answered > to_time(options_.stop_time) && reading_.moving) {
      escalate("the gripper moves on although CMD STOP was answered", now);
    }
  } else if (s.tries < options_.tries) {
    ++s.tries;
    ++counters_.unanswered;
    s.last_sent = now;
    if (!lost_) send_(encode(PlainRequest{Command::kStop}));  // else check_connection does
  } else if (s.moved || reading_.moving) {
    escalate("CMD STOP is not answered", now);
  } else {  // it stood; when it is lost, check_connection goes on asking
    if (!lost_) note_(true, "no answer to CMD STOP");
    stopping_.reset();
  }
}

void Driver::escalate(const std::string& words, Time now) {
  note_(true, words + ": CMD FAST STOP is sent until the module shows it");
  begin_stopping(now, true);
}

// What is held must go on to show it: jaws where they were blocked, and a current that presses.
void Driver::watch_grip() {
  if (!reading_.blocked) return;
  if (std::abs(reading_.opening - gripped_at_) > options_.grip_give) {
    lose_grip("the jaws went from " + millimetres(gripped_at_) + " to " +
              millimetres(reading_.opening));
  } else if (last_state_ - pressed_ > to_time(options_.blocked_time)) {
    lose_grip("nothing presses any more");
  }
}

// A command that is being repeated goes on where it is; a motion that had ended is not resumed.
void Driver::lose_grip(const std::string& words) {
  reading_.blocked = false;
  note_(true, "the grip is lost: " + words);
  if (!motion_.continuous || !motion_.ended) return;
  motion_.ended = motion_.blocked = false;
  motion_.seen_moving = true;
  motion_.standing_since.reset();
}

}  // namespace prehend::drivers::pg70
