#include "drivers/barrett/driver/device.h"

#include <utility>

namespace prehend::drivers::barrett {
namespace {

constexpr auto kTick = std::chrono::milliseconds(2);  // the next question waits no longer
constexpr auto kPause = std::chrono::milliseconds(20);
constexpr int kMostAtOnce = 64;  // frames between two looks at the time

}  // namespace

std::unique_ptr<CanBus> open_hand_bus(const std::string& name, unsigned bit_rate) {
  std::vector<std::uint16_t> identifiers;
  for (std::size_t i = 0; i < kAxes; ++i) {
    for (const Group group : {Group::kReply, Group::kPosition, Group::kTactileAll}) {
      identifiers.push_back(reply_identifier(i, group));
    }
  }
  return open_can_bus(name, bit_rate, identifiers);
}

Device::Device(const DriverOptions& options, Open open, OnState on_state, Driver::Note note,
               double retry, OnRound on_round, Driver::OnPad on_pad)
    : open_(std::move(open)),
      on_state_(std::move(on_state)),
      on_round_(std::move(on_round)),
      note_(std::move(note)),
      reopening_(retry, note_),
      // Called with the lock held, by the driver. What cannot be sent is lost; its answer is
      // missed.
      driver_(
          options,
          [this](const CanFrame& frame) -> std::string {
            return bus_ ? bus_->send(frame) : "there is no bus to the hand";
          },
          note_, std::move(on_pad)),
      thread_([this] { run(); }) {}

Device::~Device() {
  ends_ = true;
  thread_.join();
}

Reading Device::reading() {
  const std::lock_guard lock(mutex_);
  return driver_.reading();
}

std::string Device::line_problem() {
  const std::lock_guard lock(mutex_);
  return line_problem_;
}

void Device::open_bus() {
  std::shared_ptr<CanBus> bus = reopening_.attempt(open_, kPause);
  const std::lock_guard lock(mutex_);
  line_problem_ = reopening_.problem();
  if (!bus) return;
  bus_ = std::move(bus);
  driver_.connected(steady_now());
}

void Device::take(const CanEvent& event) {
  switch (event.kind) {
    case CanEvent::Kind::kDisturbed:
      note_(true, event.words);
      return;
    case CanEvent::Kind::kBusOff:
    case CanEvent::Kind::kInterfaceDown:
      line_problem_ = bus_->name() + ": " + event.words;
      return driver_.disconnected(line_problem_);
    case CanEvent::Kind::kRestarted:
      line_problem_.clear();
      note_(false, event.words);
      if (!driver_.reading().is_connected()) driver_.connected(steady_now());
      return;
    case CanEvent::Kind::kClosed:
      line_problem_ = bus_->name() + " is gone: " + event.words;
      driver_.disconnected(line_problem_);
      bus_.reset();
      return;
  }
}

void Device::serve() {
  const std::shared_ptr<CanBus> bus = bus_;  // set by this thread only
  auto input = bus->receive(kTick);
  Reading reading;
  bool is_news = false;
  {
    const std::lock_guard lock(mutex_);
    const std::uint64_t states = driver_.reading().states;
    const DriverState state = driver_.reading().state;
    for (int i = 0; input && i < kMostAtOnce; ++i) {
      if (const auto* event = std::get_if<CanEvent>(&*input)) {
        take(*event);
      } else {
        driver_.receive(std::get<CanFrame>(*input), steady_now());
      }
      const bool goes_on = bus_ && i + 1 < kMostAtOnce;
      input = goes_on ? bus->receive(std::chrono::nanoseconds(0)) : std::nullopt;
    }
    driver_.update(steady_now());
    reading = driver_.reading();
    is_news = reading.states != states || reading.state != state;
  }
  if (is_news) on_state_(reading);
}

void Device::round() {
  if (!on_round_) return;
  const std::string why = on_round_(reading());
  if (why.empty()) return;
  with_driver([&](Driver& driver, Time now) { driver.begin_anew(why, now); });
  on_round_(reading());
}

void Device::run() {
  while (!ends_) {
    if (bus_) {
      serve();
    } else {
      open_bus();
    }
    round();
  }
  stop_at_end();
}

void Device::stop_at_end() {
  if (!bus_) return;
  constexpr auto kPatience = std::chrono::seconds(1);
  with_driver([](Driver& driver, Time now) { driver.stop(now, "the driver ends"); });
  const Time end = steady_now() + kPatience;
  while (bus_ && steady_now() < end) {
    serve();
    if (on_round_) on_round_(reading());
    if (with_driver([](Driver& driver, Time) { return driver.is_settled(); })) return;
  }
  if (bus_) note_(true, "the hand was told to stop, but was not seen to stand");
}

}  // namespace prehend::drivers::barrett
