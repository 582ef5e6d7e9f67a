#pragma once

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <string>
#include <thread>
#include <vector>

#include "drivers/barrett/driver/driver.h"
#include "drivers/wire/can/can_bus.h"
#include "drivers/wire/stream/reopening.h"

namespace prehend::drivers::barrett {

/// The bus of a hand, as the host hears it: "can0", "slcan:/dev/ttyACM0"; `bit_rate` as
/// open_can_bus. @throws geometry::InputError as that.
std::unique_ptr<CanBus> open_hand_bus(const std::string& name, unsigned bit_rate);

/// A Driver that lives: a thread receives, keeps time, opens the bus and opens it again whenever it
/// is gone. Commands may come from any thread.
class Device {
 public:
  using Open = std::function<std::unique_ptr<CanBus>()>;
  using OnState = std::function<void(const Reading&)>;
  /// Returns why the connection has to begin anew; "" when it need not.
  using OnRound = std::function<std::string(const Reading&)>;

  /// `open` throws std::runtime_error while there is no bus; it is tried every `retry` seconds.
  /// `on_state` is called by the thread after each whole round of readings and whenever the
  /// driver's state changes; `on_pad` by the thread, `note` by any. `on_round` is called by the
  /// thread each time it has served the bus, at least every 25 ms: what stops being called is a
  /// driver that hangs. None may call the device.
  Device(const DriverOptions& options, Open open, OnState on_state, Driver::Note note,
         double retry = 0.5, OnRound on_round = {}, Driver::OnPad on_pad = {});
  /// Stops the hand and waits until that is seen, at most a second. What it holds stays held: the
  /// worm gears of the fingers need no motor.
  ~Device();

  /// Runs `work` on the driver with the present time, between two frames.
  template <class Work>
  auto with_driver(Work&& work) {
    const std::lock_guard lock(mutex_);
    return work(driver_, steady_now());
  }
  Reading reading();
  /// What is wrong with the bus; "" while it is there, or when it is too early to say.
  std::string line_problem();

 private:
  void run();
  void open_bus();
  void serve();
  void take(const CanEvent& event);
  void round();
  void stop_at_end();

  Open open_;
  OnState on_state_;
  OnRound on_round_;
  Driver::Note note_;
  Reopening reopening_;
  std::mutex mutex_;  // guards what follows
  std::string line_problem_;
  std::shared_ptr<CanBus> bus_;
  Driver driver_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::barrett
