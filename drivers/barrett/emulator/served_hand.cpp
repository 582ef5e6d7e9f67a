#include "drivers/barrett/emulator/served_hand.h"

#include <utility>
#include <variant>

namespace prehend::drivers::barrett {

ServedHand::ServedHand(const HandOptions& options, std::unique_ptr<CanBus> bus)
    : bus_(std::move(bus)),
      // What cannot be sent is lost, as on a real wire; the host notices.
      hand_(options, [this](const CanFrame& frame) { bus_->send(frame); }),
      thread_([this] { run(); }) {}

ServedHand::~ServedHand() {
  ends_ = true;
  thread_.join();
}

void ServedHand::run() {
  constexpr auto kTick = std::chrono::milliseconds(1);
  constexpr int kMostAtOnce = 64;  // frames between two looks at the time
  while (!ends_) {
    auto input = bus_->receive(kTick);
    const std::lock_guard lock(mutex_);
    const Time now = steady_now();
    for (int i = 0; input; ++i) {
      if (const auto* frame = std::get_if<CanFrame>(&*input)) hand_.receive(*frame, now);
      if (i == kMostAtOnce) break;
      input = bus_->receive(std::chrono::nanoseconds(0));
    }
    hand_.update(now);
  }
}

}  // namespace prehend::drivers::barrett
