#pragma once

#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <variant>

#include "drivers/wire/can/can_bus.h"
#include "drivers/wire/hand/port_event.h"
#include "drivers/wire/time/time.h"

namespace prehend::drivers {

/// As StreamPort, of a CAN bus: some frames at once.
class BusPort {
 public:
  using Line = CanBus;
  explicit BusPort(std::unique_ptr<CanBus> bus) : bus_(std::move(bus)) {}

  const std::string& name() const { return bus_->name(); }
  std::string send(const CanFrame& frame) { return bus_->send(frame); }
  void wait(std::chrono::nanoseconds most) { input_ = bus_->receive(most); }
  template <class Driver, class OnEvent>
  void pass_on(Driver& driver, const OnEvent& on_event) {
    constexpr int kMostAtOnce = 64;  // frames between two looks at the time
    for (int i = 0; input_ && i < kMostAtOnce; ++i) {
      const CanInput input = *std::exchange(input_, std::nullopt);
      if (const auto* event = std::get_if<CanEvent>(&input)) {
        if (!on_event(event_of(event->kind), event->words)) return;
      } else {
        driver.receive(std::get<CanFrame>(input), steady_now());
      }
      if (i + 1 < kMostAtOnce) input_ = bus_->receive(std::chrono::nanoseconds(0));
    }
  }

 private:
  static PortEvent event_of(CanEvent::Kind kind) {
    switch (kind) {
      case CanEvent::Kind::kDisturbed:
        return PortEvent::kRemark;
      case CanEvent::Kind::kBusOff:
      case CanEvent::Kind::kInterfaceDown:
        return PortEvent::kDown;
      case CanEvent::Kind::kRestarted:
        return PortEvent::kUp;
      case CanEvent::Kind::kClosed:
        break;
    }
    return PortEvent::kClosed;
  }

  std::unique_ptr<CanBus> bus_;
  std::optional<CanInput> input_;
};

}  // namespace prehend::drivers
