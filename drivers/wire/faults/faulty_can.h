#pragma once

#include <atomic>
#include <memory>
#include <mutex>
#include <string>
#include <utility>

#include "drivers/wire/can/can_bus.h"
#include "drivers/wire/faults/faulty_line.h"

namespace prehend::drivers {

/// A participant whose frames suffer on their way out. Late frames leave when send() or receive()
/// is called next.
class FaultyCan : public CanBus {
 public:
  explicit FaultyCan(std::unique_ptr<CanBus> bus, std::uint64_t seed = 1)
      : bus_(std::move(bus)), line_(&corrupt, seed) {}

  void set_faults(const LineFaults& faults) {
    const std::lock_guard lock(mutex_);
    line_.set_faults(faults);
  }
  std::optional<CanInput> receive(std::chrono::nanoseconds timeout) override {
    deliver();
    return bus_->receive(timeout);
  }
  std::string send(const CanFrame& frame) override {
    {
      const std::lock_guard lock(mutex_);
      line_.push(frame, steady_now());
    }
    return deliver();
  }
  const std::string& name() const override { return bus_->name(); }

 private:
  static void corrupt(CanFrame& frame, std::mt19937_64& random) {
    if (frame.size > 0)
      frame.data[random() % frame.size] ^= static_cast<std::uint8_t>(1 << random() % 8);
  }
  std::string deliver() {
    const std::lock_guard lock(mutex_);
    std::string problem;
    while (const auto frame = line_.pop(steady_now())) problem = bus_->send(*frame);
    return problem;
  }

  std::unique_ptr<CanBus> bus_;
  std::mutex mutex_;
  FaultyLine<CanFrame> line_;
};

}  // namespace prehend::drivers
