#include "drivers/pg70/driver/device.h"

#include <utility>

namespace prehend::drivers::pg70 {
namespace {

// Of watchdogs, when nothing comes: longer than the usual period of states, so that it wakes nobody
// while they do.
constexpr auto kTick = std::chrono::milliseconds(25);

}  // namespace

Device::Device(const DriverOptions& options, Open open, OnState on_state, Driver::Note note,
               double retry)
    : open_(std::move(open)),
      on_state_(std::move(on_state)),
      reopening_(retry, note),
      driver_(
          options, [this](const Content& content) { return send(content); }, std::move(note)),
      thread_([this] { run(); }) {}

Device::~Device() {
  ends_ = true;
  thread_.join();
}

Reading Device::reading() {
  const std::lock_guard lock(mutex_);
  return driver_.reading();
}

// Called with the lock held, by the driver.
std::string Device::send(const Content& content) {
  return link_ ? link_->send(Direction::kCommand, content) : "there is no link to the gripper";
}

void Device::open_link() {
  std::shared_ptr<Link> link = reopening_.attempt(open_, kTick);
  if (!link) return;
  const std::lock_guard lock(mutex_);
  link_ = std::move(link);
  driver_.connected(steady_now());
}

void Device::serve(std::optional<LinkInput> input) {
  Reading reading;
  bool is_news = false;
  {
    const std::lock_guard lock(mutex_);
    const Time now = steady_now();
    const Reading before = driver_.reading();
    if (input && std::holds_alternative<LinkEvent>(*input)) {
      const auto& event = std::get<LinkEvent>(*input);
      driver_.link_event(event, now);
      if (event.kind == LinkEvent::Kind::kClosed) link_.reset();
    } else if (input) {
      driver_.receive(std::get<Incoming>(*input), now);
    }
    driver_.update(now);
    reading = driver_.reading();
    is_news = reading.states != before.states || reading.state != before.state;
  }
  if (is_news) on_state_(reading);
}

void Device::run() {
  while (!ends_) {
    const std::shared_ptr<Link> link = link_;  // set by this thread only
    if (!link) {
      open_link();
      continue;
    }
    serve(link->receive(kTick));
    damaged_ = link->damaged();
  }
  stop_at_end();
}

void Device::stop_at_end() {
  if (!link_) return;
  constexpr auto kPatience = std::chrono::milliseconds(200);
  const Time end = steady_now() + kPatience;
  with_driver([](Driver& driver, Time now) { driver.stop(now); });
  // Until it is seen to stand, so that the stop is not lost with this process.
  while (link_ && steady_now() < end) {
    serve(link_->receive(kTick));
    if (with_driver([](Driver& driver, Time) { return driver.is_settled(); })) break;
  }
}

}  // namespace prehend::drivers::pg70
