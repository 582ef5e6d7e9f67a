#include "drivers/wire/guardian/guarded.h"

namespace prehend::drivers {

bool Guarded::progress(Watch watch) {
  if (!guardian_) return false;
  const Guardian::News news = guardian_->progress(watch);
  if (!news.problem.empty()) note_(true, news.problem);
  const bool is_there = guardian_->process() >= 0;
  const std::lock_guard lock(mutex_);
  problem_ = is_there ? "" : "no guardian would stop the " + device_ + " if this process died";
  return news.stopped_device;
}

std::string Guarded::problem() const {
  const std::lock_guard lock(mutex_);
  return problem_;
}

}  // namespace prehend::drivers
