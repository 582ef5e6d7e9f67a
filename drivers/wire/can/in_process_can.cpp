#include "drivers/wire/can/in_process_can.h"

#include <algorithm>
#include <utility>

namespace prehend::drivers {

class InProcessCan::Participant : public CanBus {
 public:
  explicit Participant(std::shared_ptr<InProcessCan> bus) : bus_(std::move(bus)) {
    const std::lock_guard lock(bus_->mutex_);
    bus_->participants_.push_back(this);
  }
  ~Participant() override {
    const std::lock_guard lock(bus_->mutex_);
    std::erase(bus_->participants_, this);
  }
  std::optional<CanInput> receive(std::chrono::nanoseconds timeout) override {
    std::unique_lock lock(bus_->mutex_);
    bus_->arrived_.wait_for(lock, timeout, [this] { return !inputs_.empty(); });
    if (inputs_.empty()) return std::nullopt;
    CanInput input = std::move(inputs_.front());
    inputs_.pop_front();
    return input;
  }
  std::string send(const CanFrame& frame) override {
    const std::lock_guard lock(bus_->mutex_);
    if (bus_->down_) return "the interface is down";
    if (bus_->bus_off_) return "the controller is off the bus";
    for (Participant* other : bus_->participants_) {
      if (other != this) other->inputs_.push_back(frame);
    }
    bus_->arrived_.notify_all();
    return {};
  }
  const std::string& name() const override { return name_; }

  std::deque<CanInput> inputs_;

 private:
  std::shared_ptr<InProcessCan> bus_;
  std::string name_ = "in-process CAN";
};

std::unique_ptr<CanBus> InProcessCan::join() {
  return std::make_unique<Participant>(shared_from_this());
}

void InProcessCan::tell(CanEvent event) {
  for (Participant* participant : participants_) participant->inputs_.push_back(event);
  arrived_.notify_all();
}

void InProcessCan::set_bus_off(bool off) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(bus_off_, off) == off) return;
  tell(off ? CanEvent{CanEvent::Kind::kBusOff, "bus-off"}
           : CanEvent{CanEvent::Kind::kRestarted, "the controller is back on the bus"});
}

void InProcessCan::set_down(bool down) {
  const std::lock_guard lock(mutex_);
  if (std::exchange(down_, down) == down) return;
  if (down) tell({CanEvent::Kind::kInterfaceDown, "the interface went down"});
}

}  // namespace prehend::drivers
