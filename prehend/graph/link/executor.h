#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <deque>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "prehend/graph/link/clock_state.h"

namespace prehend::graph {

/// What is said of a thrown thing that is no std::exception.
inline constexpr const char* kForeignException = "an exception that is no std::exception";

/// Something that calls user code: a subscription, a service, a timer, …
class CallbackSource {
 public:
  /// `name`: for error messages, e.g. "subscription of /objects".
  explicit CallbackSource(std::string name) : name_(std::move(name)) {}
  virtual ~CallbackSource() = default;
  CallbackSource(const CallbackSource&) = delete;
  CallbackSource& operator=(const CallbackSource&) = delete;

  const std::string& name() const { return name_; }
  /// Runs one callback if one is due; none after close(). False when there was nothing to do, or
  /// another thread runs one just now. Lets the callback's exceptions through.
  bool run();
  /// Ends the source: when it returns no callback runs, except the one that called close().
  void close();
  bool is_closed() const;

 protected:
  /// Runs one callback outside every lock. False when none was due.
  virtual bool run_one() = 0;

 private:
  const std::string name_;
  mutable std::mutex mutex_;
  std::condition_variable finished_;
  bool closed_ = false;
  bool running_ = false;
  std::thread::id runner_;
};

/// Calls its function every period of the clock, or once.
class TimerSource : public CallbackSource {
 public:
  TimerSource(std::shared_ptr<Clock::State> clock, std::int64_t period, bool once,
              std::function<void()> callback);
  /// [ns of timer_now()] when due next; moves on when the simulated clock starts or jumps back.
  std::int64_t due(std::int64_t now);

 protected:
  bool run_one() override;

 private:
  std::shared_ptr<Clock::State> clock_;
  const std::int64_t period_;
  const bool once_;
  std::function<void()> callback_;
  std::mutex mutex_;
  bool started_ = false;
  std::int64_t last_ = 0;  // time of the last look
  std::int64_t next_ = 0;
};

/// Runs callbacks one at a time in the order they came due.
class Executor {
 public:
  /// `on_error` is told of exceptions that leave callbacks. `busy_wait`: see NodeOptions.
  Executor(std::shared_ptr<Clock::State> clock,
           std::function<void(const std::string& source, const std::string& what)> on_error,
           std::chrono::nanoseconds busy_wait = {})
      : clock_(std::move(clock)), on_error_(std::move(on_error)), busy_wait_(busy_wait) {}

  /// Asks for `count` runs of the source. May be called from any thread.
  void schedule(std::shared_ptr<CallbackSource> source, std::size_t count = 1);
  /// Asks for one call of `work`.
  void schedule(std::string name, std::function<void()> work);
  void add_timer(const std::shared_ptr<TimerSource>& timer);
  /// Runs the source in this thread now; exceptions go to `on_error`. As CallbackSource::run.
  bool run_now(CallbackSource& source);
  /// Looks at the clock again.
  void wake();
  /// Runs callbacks in this thread until stop(). Throws std::runtime_error when it runs already.
  void run();
  void stop();
  bool is_stopped() const;

 private:
  std::shared_ptr<CallbackSource> next(std::unique_lock<std::mutex>& lock);
  bool look_out(std::unique_lock<std::mutex>& lock, std::int64_t no_longer_than);
  void tell_news();
  std::shared_ptr<CallbackSource> due_timer(std::int64_t now, std::int64_t& next_due);

  std::shared_ptr<Clock::State> clock_;
  std::function<void(const std::string&, const std::string&)> on_error_;
  const std::chrono::nanoseconds busy_wait_;
  mutable std::mutex mutex_;
  std::condition_variable changed_;
  std::atomic<std::uint64_t> news_ = 0;  // counts what changed_ is told
  struct Ready {
    std::shared_ptr<CallbackSource> source;
    std::size_t runs;
  };
  std::deque<Ready> ready_;
  std::vector<std::weak_ptr<TimerSource>> timers_;
  bool timer_ran_last_ = false;  // so that a timer that is always due does not starve the rest
  bool running_ = false;
  bool stopped_ = false;
};

}  // namespace prehend::graph
