#include "tools/grasp_plan/progress.h"

namespace prehend::tools {

using std::chrono::steady_clock;

Progress::Progress(std::chrono::milliseconds patience, std::FILE* stream)
    : patience_(patience), stream_(stream), watcher_([this] { watch(); }) {}

Progress::~Progress() {
  {
    const std::lock_guard lock(mutex_);
    ended_ = true;
  }
  changed_.notify_one();
  watcher_.join();
}

void Progress::stage(const std::string& what) {
  {
    const std::lock_guard lock(mutex_);
    if (patience_.count() <= 0) {
      std::fprintf(stream_, "%s ...\n", what.c_str());
      return;
    }
    silent_ = what;
    told_at_ = steady_clock::now() + patience_;
  }
  changed_.notify_one();
}

void Progress::over() {
  const std::lock_guard lock(mutex_);
  silent_.clear();
}

void Progress::watch() {
  std::unique_lock lock(mutex_);
  while (!ended_) {
    if (silent_.empty()) {
      changed_.wait(lock);
    } else if (steady_clock::now() < told_at_) {
      changed_.wait_until(lock, told_at_);
    } else {
      std::fprintf(stream_, "%s ...\n", silent_.c_str());
      std::fflush(stream_);
      silent_.clear();
    }
  }
}

std::string with_commas(std::size_t number) {
  std::string text = std::to_string(number);
  for (std::size_t behind = 3; behind < text.size(); behind += 4) {
    text.insert(text.size() - behind, ",");
  }
  return text;
}

}  // namespace prehend::tools
