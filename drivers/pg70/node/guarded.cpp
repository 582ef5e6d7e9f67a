#include "drivers/pg70/node/guarded.h"

namespace prehend::drivers::pg70 {

Watch watch_of(const Reading& reading) {
  switch (reading.state) {
    case DriverState::kDisconnected:
      return Watch::kOff;
    case DriverState::kFault:
    case DriverState::kUnreferenced:
    case DriverState::kStanding:
    case DriverState::kHolding:
      return reading.moving ? Watch::kMoving : Watch::kStanding;
    default:
      return Watch::kMoving;
  }
}

bool Guarded::progress(const Reading& reading) {
  if (!guardian_) return false;
  const Guardian::News news = guardian_->progress(watch_of(reading));
  if (!news.problem.empty()) note_(true, news.problem);
  const bool is_there = guardian_->process() >= 0;
  const std::lock_guard lock(mutex_);
  problem_ = is_there ? "" : "no guardian would stop the gripper if this process died";
  return news.stopped_gripper;
}

std::string Guarded::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

}  // namespace prehend::drivers::pg70
