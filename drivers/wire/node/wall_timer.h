#pragma once

#include <condition_variable>
#include <functional>
#include <mutex>
#include <thread>
#include <utility>

#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// Calls back every `seconds` in a thread of its own, whatever the graph's clock does: devices live
/// in real time. Destroying it waits for a call that runs.
class WallTimer {
 public:
  WallTimer(double seconds, std::function<void()> callback)
      : thread_([this, period = to_time(seconds), callback = std::move(callback)] {
          std::unique_lock lock(mutex_);
          while (!ends_.wait_for(lock, period, [this] { return is_ended_; })) {
            lock.unlock();
            callback();
            lock.lock();
          }
        }) {}
  ~WallTimer() {
    {
      const std::lock_guard lock(mutex_);
      is_ended_ = true;
    }
    ends_.notify_all();
    thread_.join();
  }
  WallTimer(const WallTimer&) = delete;
  WallTimer& operator=(const WallTimer&) = delete;

 private:
  std::mutex mutex_;
  std::condition_variable ends_;
  bool is_ended_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers
