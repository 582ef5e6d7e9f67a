#include "nodes/viewer/tasks.h"

#include <exception>
#include <limits>
#include <utility>

namespace prehend::nodes {

Tasks::Tasks(int threads, Failed failed) : failed_(std::move(failed)) {
  for (int i = 0; i < threads; ++i) threads_.emplace_back([this] { run(); });
}

Tasks::~Tasks() { stop(); }

void Tasks::stop() {
  {
    const std::lock_guard lock(mutex_);
    ends_ = true;
    waiting_.clear();
  }
  news_.notify_all();
  for (std::thread& thread : threads_) {
    if (thread.joinable()) thread.join();
  }
}

void Tasks::post(Task task) {
  post_unless_full(std::move(task), std::numeric_limits<std::size_t>::max());
}

bool Tasks::post_unless_full(Task task, std::size_t most) {
  {
    const std::lock_guard lock(mutex_);
    if (waiting_.size() >= most) return false;
    if (!ends_) waiting_.push_back(std::move(task));
  }
  news_.notify_one();
  return true;
}

void Tasks::run() {
  while (true) {
    Task task;
    {
      std::unique_lock lock(mutex_);
      news_.wait(lock, [this] { return ends_ || !waiting_.empty(); });
      if (ends_) return;
      task = std::move(waiting_.front());
      waiting_.pop_front();
    }
    try {
      task();
    } catch (const std::exception& error) {
      failed_(error.what());
    }
  }
}

}  // namespace prehend::nodes
