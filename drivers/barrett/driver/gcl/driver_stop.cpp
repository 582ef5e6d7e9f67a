// What makes sure of a stop, and of a clean line: Ctrl-C until a prompt comes and nothing behind
// it.

#include <algorithm>

#include "drivers/barrett/driver/gcl/driver.h"

namespace prehend::drivers::barrett::gcl {

// In RealTime mode a hand that misses a byte of a block takes what comes for it. Zeros before the
// Ctrl-C then end the block, and the next of them is no header, which ends RealTime mode, too.
// Where something is amiss so many Ctrl-Cs come that one of them must be a header; as velocities
// they are the slowest. A hand answers each of them, so that there is one where all is well.
void Driver::begin_sync(Time now, bool is_well) {
  const bool loops = mode_ == Mode::kInLoop;
  const bool may_loop = loops || (mode_ == Mode::kAsking && step_.kind == Step::Kind::kLoop);
  if (loops && is_well) send_(encode_control(Header::kControlOnly, {}, layout_));
  const std::size_t aborts = may_loop && !(loops && is_well) ? layout_.control_size() + 1 : 1;
  is_block_out_ = false;
  for (AxisMotion& axis : motion_.axes) axis.velocity = 0;
  mode_ = Mode::kSyncing;
  received_.clear();
  sent_ = last_byte_ = now;
  sync_tries_ = 0;
  write(std::string(aborts, kAbort));
}

void Driver::watch_sync(Time now) {
  constexpr std::size_t kMostBytes = 40;  // that Ctrl-C makes it say
  const bool is_quiet = now - last_byte_ >= to_time(options_.quiet_time);
  if (is_quiet && ends_in_prompt(received_)) return synced(now);
  const bool comes = now - last_byte_ < to_time(options_.stop_repeat);
  if (now - sent_ < to_time(options_.stop_repeat + line_time(kMostBytes)) ||
      (comes && !received_.empty() && now - sent_ < to_time(options_.loss_time))) {
    return;
  }
  ++sync_tries_;
  ++counters_.unanswered;
  // It may talk at the other rate: the one that it has after power-on, or what was agreed on.
  const bool tries_other = options_.fast_baud != 0 && sync_tries_ % 2 == 0;
  if (tries_other) {
    select_baud(baud_ == options_.baud ? options_.fast_baud : options_.baud);
  }
  received_.clear();
  sent_ = now;
  // An empty line makes it prompt where Ctrl-C alone does not.
  write(std::string(layout_.control_size() + 1, kAbort) + "\r");
}

void Driver::synced(Time now) {
  mode_ = Mode::kIdle;
  ++counters_.replies;
  received_.clear();
  samples_.clear();
  if (!is_connected_ && steps_.empty()) add_connection_steps();
  if (stopping_ && !stopping_->answered) stopping_->answered = now;
  next_cycle_ = now;
}

// A stop that is under way is not begun anew: its Ctrl-C goes on until it is answered.
void Driver::stop(Time now, const std::string& why) {
  const bool moved = reading_.moving;
  begins_by_initialising_ = false;  // also before there is a hand: what is stopped begins nothing
  end_motion(why);
  reading_.blocked.fill(false);
  if (!has_line_ || !is_connected_) return;  // a connection begins with one
  if (!stopping_) stopping_.emplace();
  stopping_->moved = stopping_->moved || moved;
  stopping_->answered.reset();
  steps_.clear();
  steps_.push_back({Step::Kind::kStatus, "FGET S"});
  if (mode_ != Mode::kSyncing) begin_sync(now, true);
  look_whether_it_moves();
  update_state();
}

void Driver::watch_stop(Time now) {
  if (!stopping_ || !stopping_->answered || !is_connected_) return;
  Stopping& s = *stopping_;
  const bool is_seen = samples_.size() > 1 && last_state_ > *s.answered;
  if (is_seen && !reading_.moving) {
    if (s.moved) note_(false, "stopped");
    stopping_.reset();
    return;
  }
  if (!reading_.moving || now - *s.answered < to_time(options_.stop_time)) return;
  if (!s.is_off) {
    note_(true,
          "the hand moves on although Ctrl-C was answered: its motors are told to switch off");
  }
  s.is_off = true;
  s.answered = now;
  steps_.push_front({Step::Kind::kSet, "T"});
}

}  // namespace prehend::drivers::barrett::gcl
