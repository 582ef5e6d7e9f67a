#include "prehend/launch/stop_schedule.h"

#include <signal.h>

namespace prehend::launch {

std::optional<StopSchedule::Step> StopSchedule::next() const {
  if (last_ == SIGKILL) return std::nullopt;
  if (hurried_) return Step{SIGKILL, begun_ + times_.hurried};
  if (last_ == SIGTERM) return Step{SIGKILL, sent_ + times_.terminate};
  return Step{SIGTERM, begun_ + times_.patience};
}

std::optional<int> StopSchedule::take_due(Time now) {
  const auto step = next();
  if (!step || step->when > now) return std::nullopt;
  last_ = step->signal;
  sent_ = now;
  return last_;
}

bool StopSchedule::is_hopeless(Time now) const {
  return last_ == SIGKILL && now >= sent_ + times_.terminate;
}

}  // namespace prehend::launch
