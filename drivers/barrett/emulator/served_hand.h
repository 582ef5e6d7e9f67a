#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <thread>

#include "drivers/barrett/emulator/hand.h"
#include "drivers/wire/can/can_bus.h"

namespace prehend::drivers::barrett {

/// A Hand that lives on a bus: a thread answers and keeps time.
class ServedHand {
 public:
  /// `bus` is the hand's end. The options' plant must outlive the object.
  ServedHand(const HandOptions& options, std::unique_ptr<CanBus> bus);
  ~ServedHand();

  /// Runs `work` on the hand with the present time, between two frames.
  template <class Work>
  auto with_hand(Work&& work) {
    const std::lock_guard lock(mutex_);
    return work(hand_, steady_now());
  }

 private:
  void run();

  std::mutex mutex_;  // guards hand_
  std::unique_ptr<CanBus> bus_;
  Hand hand_;
  std::atomic<bool> ends_ = false;
  std::thread thread_;
};

}  // namespace prehend::drivers::barrett
