#pragma once

#include <poll.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <thread>
#include <utility>
#include <vector>

#include <zmq.hpp>

namespace prehend::graph {

/// One ZeroMQ context and the loop that works with its sockets, in turns. The loop's thread takes
/// them; another one may take a turn when nobody else does (try_turn), or hand over work with
/// post(). Everything else may be called within a turn only, "in the loop's thread" for short.
class IoLoop {
 public:
  using Time = std::chrono::steady_clock::time_point;

  IoLoop();
  ~IoLoop();
  IoLoop(const IoLoop&) = delete;
  IoLoop& operator=(const IoLoop&) = delete;

  /// Runs `work` in the loop's thread, in the order posted. After close() it does nothing and
  /// returns false. May be called from any thread, and by a signal-safe wake() too.
  bool post(std::function<void()> work);
  /// Makes the loop look round now. Async-signal-safe.
  void wake() const;
  /// Does `work` in the calling thread now, as if it had been posted. False, and it was not done,
  /// when another turn is being taken or posted work waits. May be called from any thread.
  template <class Work>
  bool try_turn(Work&& work) {
    if (!begin_turn()) return false;
    work();
    end_turn();
    return true;
  }
  /// No work is taken any more; run() returns when what was posted before is done.
  void close();

  /// Until close(). `busy_wait`: see NodeOptions.
  void run(std::chrono::nanoseconds busy_wait = {});

  zmq::context_t& context() { return context_; }
  /// Calls `readable` whenever the socket has something to receive.
  void watch(zmq::socket_ref socket, std::function<void()> readable);
  void unwatch(zmq::socket_ref socket);
  /// To be told after sending: that may swallow the news of something to receive, which the
  /// socket's file descriptor tells but once.
  void touch(zmq::socket_ref socket);
  /// Calls `tick` about every `period`.
  void every(std::chrono::milliseconds period, std::function<void()> tick);
  /// Once, at the next turn but not before 1 ms.
  void soon(std::function<void()> work);
  /// Once, at `when` or up to 1 ms later, unless the alarm is cancelled before.
  using Alarm = std::pair<Time, std::uint64_t>;
  Alarm at(Time when, std::function<void()> work);
  void cancel(const Alarm& alarm) { alarms_.erase(alarm); }

 private:
  struct Tick {
    std::chrono::milliseconds period;
    Time next;
    std::function<void()> work;
  };

  struct Watch {
    int file;
    std::function<void()> readable;
    bool look = true;  // there may be something to receive without its file telling
  };

  static void wait(std::vector<pollfd>& files, std::chrono::milliseconds timeout,
                   std::chrono::nanoseconds busy_wait);
  bool begin_turn();
  void end_turn();
  bool take_turn(const std::vector<void*>& readable);
  bool look_again();
  void run_posted();
  void run_ticks();
  void run_soon();
  void run_alarms();
  Time next_multiple(std::chrono::milliseconds period) const;
  std::chrono::milliseconds time_to_next_tick() const;

  zmq::context_t context_;
  int wake_fd_;
  std::mutex mutex_;
  std::vector<std::function<void()>> posted_;
  bool closed_ = false;
  std::mutex turn_;
  std::atomic<std::thread::id> turn_taker_{};
  std::map<void*, Watch> watches_;
  const Time begun_ = std::chrono::steady_clock::now();
  std::vector<Tick> ticks_;
  std::vector<std::function<void()>> soon_;
  std::map<Alarm, std::function<void()>> alarms_;  // by time, then in the order they were set
  std::uint64_t alarm_count_ = 0;
};

}  // namespace prehend::graph
