#include "prehend/graph/link/executor.h"

#include <algorithm>
#include <limits>
#include <stdexcept>

#include "prehend/graph/link/callback_scope.h"

namespace prehend::graph {
namespace {

class OneCall : public CallbackSource {
 public:
  OneCall(std::string name, std::function<void()> work)
      : CallbackSource(std::move(name)), work_(std::move(work)) {}

 protected:
  bool run_one() override {
    work_();
    return true;
  }

 private:
  std::function<void()> work_;
};

}  // namespace

bool CallbackSource::run() {
  {
    const std::lock_guard lock(mutex_);
    if (closed_ || running_) return false;
    running_ = true;
    runner_ = std::this_thread::get_id();
  }
  struct Finish {
    CallbackSource& source;
    ~Finish() {
      const std::lock_guard lock(source.mutex_);
      source.running_ = false;
      source.finished_.notify_all();
    }
  } finish{*this};
  return run_one();
}

void CallbackSource::close() {
  std::unique_lock lock(mutex_);
  closed_ = true;
  if (runner_ == std::this_thread::get_id()) return;
  finished_.wait(lock, [&] { return !running_; });
}

bool CallbackSource::is_closed() const {
  const std::lock_guard lock(mutex_);
  return closed_;
}

TimerSource::TimerSource(std::shared_ptr<Clock::State> clock, std::int64_t period, bool once,
                         std::function<void()> callback)
    : CallbackSource("timer"),
      clock_(std::move(clock)),
      period_(period),
      once_(once),
      callback_(std::move(callback)) {
  if (clock_->has_started()) {
    started_ = true;
    last_ = clock_->timer_now();
    next_ = last_ + period_;
  }
}

std::int64_t TimerSource::due(std::int64_t now) {
  const std::lock_guard lock(mutex_);
  if (!started_ || now < last_) next_ = now + period_;
  started_ = true;
  last_ = now;
  return next_;
}

bool TimerSource::run_one() {
  {
    const std::lock_guard lock(mutex_);
    const std::int64_t now = clock_->timer_now();
    if (now < next_) return false;
    next_ = now + (period_ - (now - next_) % period_);
  }
  if (once_) close();
  callback_();
  return true;
}

void Executor::schedule(std::shared_ptr<CallbackSource> source, std::size_t count) {
  const std::lock_guard lock(mutex_);
  if (stopped_) return;
  if (!ready_.empty() && ready_.back().source == source) {
    ready_.back().runs += count;
  } else {
    ready_.push_back({std::move(source), count});
  }
  tell_news();
}

void Executor::schedule(std::string name, std::function<void()> work) {
  schedule(std::make_shared<OneCall>(std::move(name), std::move(work)));
}

void Executor::add_timer(const std::shared_ptr<TimerSource>& timer) {
  const std::lock_guard lock(mutex_);
  timers_.push_back(timer);
  tell_news();
}

void Executor::wake() {
  const std::lock_guard lock(mutex_);
  tell_news();
}

std::shared_ptr<CallbackSource> Executor::due_timer(std::int64_t now, std::int64_t& next_due) {
  std::erase_if(timers_, [](const auto& timer) {
    const auto alive = timer.lock();
    return !alive || alive->is_closed();
  });
  std::shared_ptr<TimerSource> first;
  for (const auto& weak : timers_) {
    const auto timer = weak.lock();
    if (!timer) continue;
    const std::int64_t due = timer->due(now);
    if (first && due >= next_due) continue;
    next_due = due;
    first = timer;
  }
  return next_due <= now ? first : nullptr;
}

void Executor::tell_news() {
  ++news_;
  changed_.notify_one();
}

// Watches out for news without sleeping; true when there are some.
bool Executor::look_out(std::unique_lock<std::mutex>& lock, std::int64_t no_longer_than) {
  if (busy_wait_.count() <= 0) return false;
  const std::uint64_t seen = news_;
  const auto end = std::chrono::steady_clock::now() +
                   std::min(busy_wait_, std::chrono::nanoseconds(no_longer_than));
  lock.unlock();
  while (news_ == seen && std::chrono::steady_clock::now() < end) std::this_thread::yield();
  lock.lock();
  return news_ != seen;
}

std::shared_ptr<CallbackSource> Executor::next(std::unique_lock<std::mutex>& lock) {
  while (!stopped_) {
    std::int64_t next_due = std::numeric_limits<std::int64_t>::max();
    const std::int64_t now = clock_->timer_now();
    if (clock_->has_started()) {
      auto timer = due_timer(now, next_due);
      if (timer && (ready_.empty() || !timer_ran_last_)) {
        timer_ran_last_ = true;
        return timer;
      }
    }
    timer_ran_last_ = false;
    if (!ready_.empty()) {
      if (--ready_.front().runs > 0) return ready_.front().source;
      auto source = std::move(ready_.front().source);
      ready_.pop_front();
      return source;
    }
    if (look_out(lock, next_due - now)) continue;
    const bool by_the_wall = clock_->mode() == ClockMode::kWall;
    if (by_the_wall && next_due != std::numeric_limits<std::int64_t>::max()) {
      changed_.wait_for(lock, std::chrono::nanoseconds(next_due - now));
    } else {
      changed_.wait(lock);
    }
  }
  return nullptr;
}

bool Executor::run_now(CallbackSource& source) {
  const CallbackScope scope(*clock_, source.name());
  try {
    return source.run();
  } catch (const std::exception& error) {
    on_error_(source.name(), error.what());
  } catch (...) {
    on_error_(source.name(), kForeignException);
  }
  return true;
}

void Executor::run() {
  std::unique_lock lock(mutex_);
  if (running_) throw std::runtime_error("the node spins already");
  running_ = true;
  while (auto source = next(lock)) {
    lock.unlock();
    run_now(*source);
    source.reset();  // may end user objects, so not under the lock
    lock.lock();
  }
  running_ = false;
}

void Executor::stop() {
  std::deque<Ready> dropped;  // destroyed outside the lock
  const std::lock_guard lock(mutex_);
  stopped_ = true;
  dropped.swap(ready_);
  tell_news();
}

bool Executor::is_stopped() const {
  const std::lock_guard lock(mutex_);
  return stopped_;
}

}  // namespace prehend::graph
