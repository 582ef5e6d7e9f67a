#include "nodes/simulation/paced_loop.h"

#include <time.h>

#include <chrono>
#include <utility>

namespace prehend::nodes {
namespace {

/// s, of this thread.
double processor_time() {
  timespec time{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &time);
  return static_cast<double>(time.tv_sec) + 1e-9 * static_cast<double>(time.tv_nsec);
}

}  // namespace

PacedLoop::PacedLoop(graph::Node& node, graph::ClockPacer& pacer, std::int64_t slice,
                     std::function<void()> step, std::function<void()> tell,
                     std::function<void(std::int64_t)> on_pace)
    : node_(node),
      pacer_(pacer),
      slice_(slice),
      step_(std::move(step)),
      tell_(std::move(tell)),
      on_pace_(std::move(on_pace)) {}

void PacedLoop::start() {
  running_ = true;
  thread_ = std::thread([this] {
    const auto start = std::chrono::steady_clock::now();
    while (running_) {
      node_.shield("simulation", [this] {
        if (wait_for_pace()) work();
      });
    }
    spent_ = std::chrono::steady_clock::now() - start;
  });
}

void PacedLoop::stop() {
  running_ = false;
  if (!thread_.joinable()) return;
  thread_.join();
  log_cost();
}

void PacedLoop::work() {
  const double start = processor_time();
  step_();
  const double stepped = processor_time();
  tell_();
  step_cost_ += stepped - start;
  tell_cost_ += processor_time() - stepped;
}

void PacedLoop::log_cost() const {
  const double simulated = 1e-9 * static_cast<double>(time_);
  if (simulated == 0) return;
  node_.log_info(
      "simulated {:.1f} s in {:.1f} s; each took {:.3g} ms of processor to step, {:.3g} ms to "
      "publish",
      simulated, std::chrono::duration<double>(spent_).count(), 1e3 * step_cost_ / simulated,
      1e3 * tell_cost_ / simulated);
}

// True when the next slice is due; false now and then, so that the thread can end.
bool PacedLoop::wait_for_pace() {
  constexpr auto kLongestWait = std::chrono::milliseconds(50);
  // Devices of real wires, which keep real time, are not to seem late by what is made up for at
  // once.
  constexpr auto kMostLag = std::chrono::milliseconds(100);
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
