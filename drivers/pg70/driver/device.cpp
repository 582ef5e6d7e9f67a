#include "drivers/pg70/driver/device.h"

#include <utility>

namespace prehend::drivers::pg70 {
namespace {

// Of watchdogs, when nothing comes: longer than the usual period of states, so that it wakes nobody
// while they do.
constexpr auto kTick = std::chrono::milliseconds(25);

}  // namespace

Device::Device(const DriverOptions& options, Open open, OnState on_state, Driver::Note note,
               double retry, OnRound on_round)
    : open_(std::move(open)),
      on_state_(std::move(on_state)),
      on_round_(std::move(on_round)),
      note_(std::move(note)),
      reopening_(retry, note_),
      driver_(
          options, [this](const Content& content) { return send(content); }, note_),
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

void Device::begin_anew(const std::string& words) {
  const std::lock_guard lock(mutex_);
  anew_ = words;
}

// Called with the lock held, by the driver.
std::string Device::send(const Content& content) {
  return link_ ? link_->send(Direction::kCommand, content) : "there is no link to the gripper";
}

void Device::open_link() {
  std::shared_ptr<Link> link = reopening_.attempt(open_, kTick);
  const std::lock_guard lock(mutex_);
  if (!link) {
    if (!reopening_.problem().empty()) line_problem_ = reopening_.problem();
    return;
  }
  line_problem_.clear();
  link_ = std::move(link);
  driver_.connected(steady_now());
}

// True when it was left, as begin_anew() asked.
bool Device::leave_link() {
  const std::lock_guard lock(mutex_);
  if (anew_.empty()) return false;
  if (link_) driver_.link_event({LinkEvent::Kind::kLeft, anew_}, steady_now());
  link_.reset();
  anew_.clear();
  return true;
}

void Device::round() {
  if (on_round_) on_round_(reading());
  if (leave_link() && on_round_) on_round_(reading());
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
      if (event.kind == LinkEvent::Kind::kDown || event.kind == LinkEvent::Kind::kClosed) {
        line_problem_ = event.words;
      } else if (event.kind == LinkEvent::Kind::kUp) {
        line_problem_.clear();
      }
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
    if (link) {
      serve(link->receive(kTick));
      damaged_ += link->damaged() - link_damaged_;
      link_damaged_ = link->damaged();
    } else {
      link_damaged_ = 0;
      open_link();
    }
    round();
  }
  stop_at_end();
}

void Device::stop_at_end() {
  if (!link_) return;
  constexpr auto kPatience = std::chrono::seconds(1);
  const Time end = steady_now() + kPatience;
  with_driver([](Driver& driver, Time now) { driver.stop(now, "the driver ends"); });
  // Until it is seen to stand, so that the stop is not lost with this process.
  while (link_ && steady_now() < end) {
    serve(link_->receive(kTick));
    if (on_round_) on_round_(reading());
    if (with_driver([](Driver& driver, Time) { return driver.is_settled(); })) return;
  }
  if (link_) note_(true, "the gripper was told to stop, but was not seen to stand");
}

}  // namespace prehend::drivers::pg70
