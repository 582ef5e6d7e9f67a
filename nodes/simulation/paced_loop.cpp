#include "nodes/simulation/paced_loop.h"

#include <chrono>
#include <utility>

namespace prehend::nodes {

PacedLoop::PacedLoop(graph::Node& node, graph::ClockPacer& pacer, std::int64_t slice,
                     std::function<void()> work, std::function<void(std::int64_t)> on_pace)
    : node_(node),
      pacer_(pacer),
      slice_(slice),
      work_(std::move(work)),
      on_pace_(std::move(on_pace)) {}

void PacedLoop::start() {
  running_ = true;
  thread_ = std::thread([this] {
    while (running_) {
      node_.shield("simulation", [this] {
        if (wait_for_pace()) work_();
      });
    }
  });
}

void PacedLoop::stop() {
  running_ = false;
  if (thread_.joinable()) thread_.join();
}

// True when the next slice is due; false now and then, so that the thread can end.
bool PacedLoop::wait_for_pace() {
  constexpr auto kLongestWait = std::chrono::milliseconds(50);
  constexpr auto kMostLag = std::chrono::milliseconds(300);
  std::this_thread::yield();  // lets waiting commands in: a mutex is not fair
  const bool is_due = pacer_.wait_for(time_ + slice_, kLongestWait) >= time_ + slice_;
  if (is_due) {
    time_ += slice_;
    if (pacer_.give_up_lag(kMostLag) && !std::exchange(slow_, true)) {
      node_.log_warning("this machine is too slow for the speed asked for; simulated time lags");
    }
  }
  const auto pace = pacer_.state();
  if (!is_due && (pace.paused != pace_.paused || pace.speed != pace_.speed)) on_pace_(time_);
  pace_ = pace;
  return is_due;
}

}  // namespace prehend::nodes
