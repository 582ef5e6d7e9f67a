#include "drivers/pg70/emulator/served_module.h"

#include <utility>

namespace prehend::drivers::pg70 {

ServedModule::ServedModule(GripperPlant& plant, const ModuleOptions& options,
                           std::unique_ptr<Link> link)
    : link_(std::move(link)),
      // What cannot be sent is lost, as on a real wire; the master notices.
      module_(
          plant, options,
          [this](Direction direction, const Content& content) { link_->send(direction, content); }),
      thread_([this] { run(); }) {}

ServedModule::~ServedModule() {
  ends_ = true;
  thread_.join();
}

void ServedModule::run() {
  constexpr auto kTick = std::chrono::milliseconds(1);
  while (!ends_) {
    auto input = link_->receive(kTick);
    const std::lock_guard lock(mutex_);
    const Time now = steady_now();
    if (input && std::holds_alternative<Incoming>(*input)) {
      module_.receive(std::get<Incoming>(*input).content, now);
    }
    module_.update(now);
  }
}

}  // namespace prehend::drivers::pg70
