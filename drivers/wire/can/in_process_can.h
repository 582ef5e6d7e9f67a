#pragma once

#include <condition_variable>
#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "drivers/wire/can/can_bus.h"

namespace prehend::drivers {

/// A CAN bus between parts of one process, for tests where the kernel has no CAN. Frames arrive in
/// order at all other participants. Thread-safe.
class InProcessCan : public std::enable_shared_from_this<InProcessCan> {
 public:
  static std::shared_ptr<InProcessCan> create() {
    return std::shared_ptr<InProcessCan>(new InProcessCan);
  }
  /// Another participant, which keeps the bus alive.
  std::unique_ptr<CanBus> join();

  /// Bus-off of all participants: sending fails, nothing arrives, each gets the event.
  void set_bus_off(bool off);
  /// The interface goes down, or up again.
  void set_down(bool down);

 private:
  class Participant;
  InProcessCan() = default;
  void tell(CanEvent event);

  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<Participant*> participants_;
  bool bus_off_ = false;
  bool down_ = false;
};

}  // namespace prehend::drivers
