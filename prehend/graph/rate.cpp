#include "prehend/graph/rate.h"

#include <fmt/core.h>

#include <cmath>
#include <limits>
#include <stdexcept>

#include "prehend/graph/link/clock_state.h"

namespace prehend::graph {

Rate::Rate(const Clock& clock, double hertz) : clock_(clock.state_) {
  if (!(hertz >= 1e-9) || !(hertz <= 1e9)) {
    throw std::invalid_argument(fmt::format("rate {} Hz must be from 1e-9 to 1e9 Hz", hertz));
  }
  period_ = std::llround(1e9 / hertz);
  if (!clock_->has_started()) return;
  begun_ = true;
  last_ = clock_->timer_now();
  next_ = last_ + period_;
}

bool Rate::sleep() {
  check_may_sleep(*clock_);
  bool waited = false;
  while (true) {
    const std::uint64_t restarts = clock_->restarts();  // before the look at the time
    if (clock_->is_stopped()) return false;
    if (clock_->has_started()) {
      const std::int64_t now = clock_->timer_now();
      if (!begun_ || now < last_) next_ = now + period_;
      begun_ = true;
      last_ = now;
      if (now >= next_) break;
    }
    waited = true;
    // Without a start yet, no tick is due before it.
    const std::int64_t until = begun_ ? next_ : std::numeric_limits<std::int64_t>::max();
    if (!clock_->sleep_until_tick(until, restarts)) return false;
  }
  const std::int64_t merged = (last_ - next_) / period_;
  overrun_ = waited ? 0 : last_ - next_;
  missed_ += static_cast<std::uint64_t>(merged);
  next_ = last_ + (period_ - (last_ - next_) % period_);
  return true;
}

}  // namespace prehend::graph
