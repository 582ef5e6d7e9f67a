#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>

#include "drivers/sdh/driver/driver.h"
#include "drivers/wire/stream/byte_stream.h"
#include "drivers/wire/stream/reopening.h"

namespace prehend::drivers::sdh {

/// A Driver that lives: a thread reads, keeps time, opens the line and opens it again whenever it
/// is gone. Commands may come from any thread.
class Device {
 public:
  using Open = std::function<std::unique_ptr<ByteStream>()>;
  using OnState = std::function<void(const Reading&)>;
  /// Returns why the connection has to begin anew; "" when it need not.
  using OnRound = std::function<std::string(const Reading&)>;

  /// `open` throws std::runtime_error while there is no line; it is tried every `retry` seconds.
  /// `on_state` is called by the thread after each whole round of readings and whenever the
  /// driver's state changes; `note` by any thread. `on_round` is called by the thread each time it
  /// has served the line, at least every 25 ms: what stops being called is a driver that hangs.
  /// None may call the device.
  Device(const DriverOptions& options, Open open, OnState on_state, Driver::Note note,
         double retry = 0.5, OnRound on_round = {});
  /// Stops the hand and waits until that is seen, at most a second; then switches its axes off as
  /// the options say, unless it holds something.
  ~Device();

  /// Runs `work` on the driver with the present time, between two replies.
  template <class Work>
  auto with_driver(Work&& work) {
    const std::lock_guard lock(mutex_);
    return work(driver_, steady_now());
  }
  Reading reading();
  /// What is wrong with the line; "" while it is there, or when it is too early to say.
  std::string line_problem();

 private:
  void run();
  void open_line();
  void serve();
  void round();
  void stop_at_end();

  const bool power_off_at_end_;
  Open open_;
  OnState on_state_;
  OnRound on_round_;
  Driver::Note note_;
  Reopening reopening_;
  std::mutex mutex_;  // guards what follows
  std::string line_problem_;
  std::shared_ptr<ByteStream> line_;
  Driver driver_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::sdh
