#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <mutex>
#include <vector>

#include <zmq.hpp>

namespace prehend::graph {

/// One ZeroMQ context and the loop of the one thread that touches its sockets. Other threads hand
/// it work with post(); everything else may be called in that thread only.
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
  /// No work is taken any more; run() returns when what was posted before is done.
  void close();

  /// Until close().
  void run();

  zmq::context_t& context() { return context_; }
  /// Calls `readable` whenever the socket has something to receive.
  void watch(zmq::socket_ref socket, std::function<void()> readable);
  void unwatch(zmq::socket_ref socket);
  /// Calls `tick` about every `period`.
  void every(std::chrono::milliseconds period, std::function<void()> tick);
  /// Once, at the next turn but not before 1 ms.
  void soon(std::function<void()> work);

 private:
  struct Tick {
    std::chrono::milliseconds period;
    Time next;
    std::function<void()> work;
  };

  void run_posted();
  void run_ticks();
  void run_soon();
  std::chrono::milliseconds time_to_next_tick() const;

  zmq::context_t context_;
  int wake_fd_;
  std::mutex mutex_;
  std::vector<std::function<void()>> posted_;
  bool closed_ = false;
  std::map<void*, std::function<void()>> watches_;
  std::vector<Tick> ticks_;
  std::vector<std::function<void()>> soon_;
};

}  // namespace prehend::graph
